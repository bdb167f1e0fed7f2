/** A computed motion: the samples that the service sends, and quantities derived from the samples. */

/**
 * @typedef {{time: number[], u: number[], u_rate: number[], v: number[], v_rate: number[], p: (number |
 *   null)[], p_rate: (number | null)[], impact: number[]}} Columns time τ in 1/ω_n;
 *   displacements over Z: u of the structure, v of the structure relative to the base, p of the particle
 */

export class History {
  /** @param {Columns} columns @param {number} r the frequency ratio */
  constructor(columns, r) {
    this.columns = columns;
    this.r = r;
    this.first = columns.time[0] ?? 0;
    /** The time of each sample in cycles since the first sample. */
    this.cycles = columns.time.map((time) => ((time - this.first) * r) / (2 * Math.PI));
    this.length = Math.round(this.cycles[this.cycles.length - 1] ?? 0);
  }

  /** Whether there is a particle. */
  get particle() {
    return this.columns.p.some((value) => value !== null);
  }

  /** Indices of the samples at which an impact ends. */
  get impacts() {
    return this.columns.impact.flatMap((struck, i) => (struck ? [i] : []));
  }

  /** The displacement of the base in units of Z, at a time in cycles. @param {number} cycle */
  base(cycle) {
    return this.at("u", cycle) - this.at("v", cycle);
  }

  /** The index of the last sample at or before a time in cycles. @param {number} cycle */
  before(cycle) {
    let low = 0;
    let high = this.cycles.length - 1;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.cycles[middle] <= cycle) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /**
   * The value of a column at a time in cycles, by linear interpolation between samples.
   *
   * @param {keyof Columns} name
   * @param {number} cycle
   */
  at(name, cycle) {
    const i = this.before(cycle);
    const column = this.columns[name];
    const here = column[i] ?? 0;
    const next = column[i + 1];
    if (next === undefined || next === null) return here;
    const span = this.cycles[i + 1] - this.cycles[i];
    return span > 0 ? here + ((next - here) * (cycle - this.cycles[i])) / span : here;
  }

  /** Position of the particle in its cavity in units of Z: 0 in the middle, ± the clearance at the walls. */
  get inCavity() {
    return this.columns.p.map((p, i) => (p === null ? null : p - this.columns.u[i]));
  }

  /** Poincaré section of the structure, one point per cycle. @returns {{u: number[], u_rate: number[]}} */
  get strobes() {
    const whole = Array.from({ length: this.length }, (_, k) => k);
    return { u: whole.map((k) => this.at("u", k)), u_rate: whole.map((k) => this.at("u_rate", k)) };
  }
}
