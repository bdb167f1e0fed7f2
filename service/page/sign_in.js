/** Sign-in with a key, which is exchanged for a cookie that no script can read. */

import { ask, refusalBox, send } from "./api.js";
import { button, el, fill } from "./dom.js";

/** A form for a key. @param {() => void} onDone called once the user is signed in @returns {Node[]} */
export function signInForm(onDone) {
  const key = el("input", {
    id: "key",
    type: "password",
    autocomplete: "current-password",
    required: true,
    maxlength: "200",
  });
  const trouble = el("div", {});
  const form = el(
    "form",
    {
      onsubmit: async (/** @type {Event} */ event) => {
        event.preventDefault();
        fill(trouble);
        try {
          await send("session", { key: /** @type {HTMLInputElement} */ (key).value.trim() });
        } catch (error) {
          fill(trouble, refusalBox(error));
          return;
        }
        await showSession();
        onDone();
      },
    },
    el(
      "p",
      {},
      el("label", { for: "key" }, "Key"),
      " ",
      key,
      " ",
      el("button", { type: "submit" }, "Sign in"),
    ),
    trouble,
  );
  const words =
    "This service requires a key. Its operator creates one with the command damperlab admin keys create.";
  return [el("h1", {}, "Sign in"), el("p", {}, words), form];
}

/** Show the name of the signed-in user in the header, with a button to sign out. */
export async function showSession() {
  const place = /** @type {HTMLElement} */ (document.getElementById("session"));
  let session;
  try {
    session = await ask("session");
  } catch {
    return; // the present view reports the failure
  }
  if (!session.needed || !session.signed_in) {
    fill(place);
    return;
  }
  const leave = async () => {
    await ask("session", {}, { method: "DELETE" });
    location.reload();
  };
  fill(place, `${session.owner} `, button("Sign out", leave));
}
