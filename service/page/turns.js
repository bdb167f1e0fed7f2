/** Lets tasks run in order, at most a given number of them at the same time. */
export class Turns {
  /** @type {(() => void)[]} */
  waiting = [];

  /** @param {number} free largest number of tasks at the same time */
  constructor(free) {
    this.free = free;
  }

  /**
   * Wait for a turn, and run a task.
   *
   * @template T
   * @param {() => Promise<T>} task
   * @returns {Promise<T>} the result of the task
   */
  async run(task) {
    if (this.free > 0) this.free -= 1;
    else await new Promise((/** @type {(value?: undefined) => void} */ begin) => this.waiting.push(begin));
    try {
      return await task();
    } finally {
      const begin = this.waiting.shift();
      if (begin) begin();
      else this.free += 1;
    }
  }
}
