import { type ChildProcess, spawn } from "node:child_process";
import { createInterface } from "node:readline";

/** A process of Python that answers requests by numbers: worker.py. */
export class Worker {
  readonly #child: ChildProcess;
  readonly #lines: AsyncIterator<string>;

  constructor(python: string, packageFolder: string, script: string) {
    const child = spawn(python, [script], {
      stdio: ["pipe", "pipe", "inherit"],
      env: { ...process.env, PYTHONPATH: packageFolder },
    });
    this.#child = child;
    this.#lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  }

  /** The answer to a request; seconds, unless worker.py says otherwise. */
  async ask(...request: string[]): Promise<number> {
    this.#child.stdin?.write(`${request.join("\t")}\n`);
    const { value, done } = await this.#lines.next();
    if (done) throw new Error(`worker.py ended at the request ${request.join(" ")}`);
    return Number(value);
  }

  close(): void {
    this.#child.kill();
  }
}
