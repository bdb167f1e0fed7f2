/** Writes the Python code that returns the content of a figure. */

/** @param {unknown} value @returns {string} */
function literal(value) {
  if (typeof value === "boolean") return value ? "True" : "False";
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (value !== null && typeof value === "object") {
    return `{${Object.entries(value)
      .map(([key, one]) => `${JSON.stringify(key)}: ${literal(one)}`)
      .join(", ")}}`;
  }
  return typeof value === "string" ? JSON.stringify(value) : String(value);
}

/**
 * A call of a method of the Python client, with the import.
 *
 * @param {string | null} study id of the study whose method is called; null for a method of the client
 * @param {string} method
 * @param {Record<string, unknown>} given arguments by name; null and undefined are left out
 */
export function pythonLine(study, method, given) {
  const named = Object.entries(given).filter(([, value]) => value !== null && value !== undefined);
  const values = named.map(([name, value]) => `${name}=${literal(value)}`);
  const client = `Client(${literal(new URL(".", document.baseURI).href.replace(/\/$/, ""))})`;
  const of = study === null ? "" : `.study(${literal(study)})`;
  return `from damperlab import Client\n\n${client}${of}.${method}(${values.join(", ")})`;
}
