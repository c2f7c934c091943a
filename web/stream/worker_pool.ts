import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import type { CoreProgram } from "../core/instantiate_core.ts";
import { compiledCore } from "../core/load_core.ts";
import { messageOfLoss, startWorker } from "../core/page_worker.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { Decoded, WorkerRequest, WorkerResponse, WorkerStart } from "./decode_worker.ts";
import type { DecodeJob, Decoder, FieldJob } from "./decoder.ts";

/**
 * Number of requests that a worker has at a time, so that it never waits for the main thread between two
 * requests.
 */
const requestsPerWorker = 2;
/** Chunks that wait are sent together up to these limits, so that a request takes as long as one large chunk. */
const together = { tasks: 32, bytes: 32 * 1024 };
/**
 * A worker that dies is replaced at once, at most this often until a chunk is decoded. After that it is
 * replaced when the next chunk is to be decoded, because a persistent fault must not start workers in a
 * loop.
 */
const maxRespawns = 3;
/**
 * Limit of the time that a worker may take to start, in steps of half a second. A suspended or busy
 * page counts fewer steps.
 */
const startSteps = 8;
const startStepMs = 500;

interface Task {
  id: number;
  job: DecodeJob | FieldJob;
  bytes: Uint8Array;
  resolve(decoded: Decoded): void;
  reject(reason: unknown): void;
}

interface Member {
  worker: Worker;
  tasks: Map<number, Task>;
  /** The number of requests without a response. */
  requests: number;
  /** The first message has been sent. */
  isStarted: boolean;
  /** It has replied. */
  isReady: boolean;
}

export interface WorkerPoolOptions {
  workers?: number;
  /**
   * The compiled code of isosplat-renderer, if the page needs it anyway. It contains the core, so
   * workers need not fetch and compile isosplat-core.
   */
  renderer?: Promise<CompiledModule>;
}

/** One core is left for the main thread and the browser. */
export function defaultWorkerCount(): number {
  const cores = typeof navigator === "undefined" ? 2 : (navigator.hardwareConcurrency ?? 2);
  return Math.min(4, Math.max(1, cores - 1));
}

/** Decodes in module workers. Buffers are transferred both ways; no memory is shared. */
export class WorkerPool implements Decoder {
  readonly #members: Member[] = [];
  readonly #waiting: Task[] = [];
  #nextId = 0;
  #respawns = 0;
  #closed = false;
  /** The reason why no worker has replied in time; cleared when one replies. */
  #silence: string | undefined;
  readonly #renderer: Promise<CompiledModule> | undefined;

  constructor({ workers = defaultWorkerCount(), renderer }: WorkerPoolOptions = {}) {
    this.#renderer = renderer;
    for (let i = 0; i < workers; ++i) this.#spawn();
  }

  decode(job: DecodeJob, bytes: Uint8Array, signal: AbortSignal): Promise<DecodedChunk> {
    return this.#decode(shapeOf(job), bytes, signal) as Promise<DecodedChunk>;
  }

  decodeField(job: FieldJob, bytes: Uint8Array, signal: AbortSignal): Promise<Uint32Array> {
    const { field } = job;
    return this.#decode({ ...shapeOf(job), field }, bytes, signal) as Promise<Uint32Array>;
  }

  #decode(job: DecodeJob | FieldJob, bytes: Uint8Array, signal: AbortSignal): Promise<Decoded> {
    if (signal.aborted) return Promise.reject(signal.reason);
    if (this.#silence) return Promise.reject(new CoreError("worker_lost", this.#silence));
    // All workers have died. The caller has waited before this attempt.
    if (this.#members.length === 0 && !this.#closed) this.#spawn();
    return new Promise((resolve, reject) => {
      // A task that a worker has begun is finished; a waiting task is removed.
      const aborted = (): void => {
        const at = this.#waiting.indexOf(task);
        if (at >= 0) this.#waiting.splice(at, 1);
        reject(signal.reason);
      };
      const task: Task = {
        id: this.#nextId++,
        job,
        bytes,
        resolve: (decoded) => {
          signal.removeEventListener("abort", aborted);
          resolve(decoded);
        },
        reject: (reason) => {
          signal.removeEventListener("abort", aborted);
          reject(reason);
        },
      };
      signal.addEventListener("abort", aborted, { once: true });
      this.#waiting.push(task);
      this.#assignTasks();
    });
  }

  close(): void {
    this.#closed = true;
    const reason = new DOMException("the decoder was closed", "AbortError");
    for (const { worker, tasks } of this.#members) {
      worker.terminate();
      for (const task of tasks.values()) task.reject(reason);
    }
    for (const task of this.#waiting) task.reject(reason);
    this.#members.length = 0;
    this.#waiting.length = 0;
  }

  #spawn(): void {
    let worker: Worker;
    try {
      worker = startWorker(
        "decode_worker.js",
        () => new Worker(new URL("./decode_worker.ts", import.meta.url), { type: "module" }),
      );
    } catch (error) {
      // Run this after the task that needs the worker has been added to the list.
      queueMicrotask(() => this.#lost(`a worker could not be started: ${String(error)}`));
      return;
    }
    const member: Member = {
      ...{ worker, tasks: new Map(), requests: 0 },
      ...{ isStarted: false, isReady: false },
    };
    this.#members.push(member);
    this.#program().then(
      (program) => {
        const message: WorkerStart = { program };
        worker.postMessage(message);
        member.isStarted = true;
        this.#awaitReady(member, startSteps);
        this.#assignTasks();
      },
      (error: unknown) =>
        this.#replace(member, error instanceof Error ? error.message : String(error)),
    );
    worker.onmessage = ({ data }: MessageEvent<WorkerResponse>) => {
      member.isReady = true;
      this.#silence = undefined;
      if ("isReady" in data) return;
      --member.requests;
      const done = data.map((result) => ({ result, task: member.tasks.get(result.id) }));
      for (const { id } of data) member.tasks.delete(id);
      this.#assignTasks();
      for (const { result, task } of done) {
        if ("decoded" in result) {
          this.#respawns = 0;
          task?.resolve(result.decoded);
        } else {
          task?.reject(new CoreError(result.status, result.message));
        }
      }
    };
    worker.onerror = (event) => {
      event.preventDefault();
      this.#replace(member, messageOfLoss(worker, event));
    };
  }

  /** The code that workers run: the renderer's if there is one, otherwise isosplat-core. */
  async #program(): Promise<CoreProgram> {
    try {
      if (this.#renderer) return { renderer: await this.#renderer };
    } catch {} // the code that loads the renderer reports this
    return { core: await compiledCore() };
  }

  /**
   * Waits for the worker's reply. The browser sends no event if a wrong program is loaded, or if
   * the program never loads.
   */
  #awaitReady(member: Member, steps: number): void {
    setTimeout(() => {
      if (member.isReady || !this.#members.includes(member)) return;
      if (steps > 1) this.#awaitReady(member, steps - 1);
      else if (!this.#members.some(({ isReady }) => isReady)) this.#giveUp();
    }, startStepMs);
  }

  /** The workers are kept, because a slow one may still reply. */
  #giveUp(): void {
    const seconds = (startSteps * startStepMs) / 1000;
    this.#silence =
      `no worker has answered for ${seconds} s: their program has not been loaded, or is another one; ` +
      "load the page again";
    for (const { tasks } of this.#members) {
      for (const task of tasks.values()) this.#waiting.push(task);
      tasks.clear();
    }
    this.#rejectWaiting(this.#silence);
  }

  #replace(member: Member, message: string): void {
    if (this.#closed) return;
    member.worker.terminate();
    const at = this.#members.indexOf(member);
    if (at < 0) return;
    this.#members.splice(at, 1);
    for (const task of member.tasks.values()) task.reject(new CoreError("worker_lost", message));
    this.#lost(message);
  }

  #lost(message: string): void {
    if (this.#closed) return;
    if (++this.#respawns <= maxRespawns) this.#spawn();
    if (this.#members.length === 0) this.#rejectWaiting(message);
    this.#assignTasks();
  }

  #rejectWaiting(message: string): void {
    for (const task of this.#waiting.splice(0)) task.reject(new CoreError("worker_lost", message));
  }

  #assignTasks(): void {
    for (const member of this.#members) {
      while (member.isStarted && member.requests < requestsPerWorker) {
        const tasks = this.#nextTasks();
        if (tasks.length === 0) return;
        ++member.requests;
        for (const task of tasks) member.tasks.set(task.id, task);
        const request: WorkerRequest = tasks.map(({ id, job, bytes }) => ({ id, job, bytes }));
        const transfer = tasks.flatMap(({ bytes }) =>
          bytes.byteLength === bytes.buffer.byteLength ? [bytes.buffer as ArrayBuffer] : [],
        );
        member.worker.postMessage(request, transfer);
      }
    }
  }

  /** Removes the tasks of the next request. */
  #nextTasks(): Task[] {
    let count = 0;
    let bytes = 0;
    for (const task of this.#waiting) {
      bytes += task.bytes.byteLength;
      if (count === together.tasks || (count > 0 && bytes > together.bytes)) break;
      ++count;
    }
    return this.#waiting.splice(0, count);
  }
}

/** What a worker needs: not the other members of a chunk, which would be copied as well. */
function shapeOf(job: DecodeJob): DecodeJob {
  const { level, blockCells, bandBegin, bandEnd, cells, checksum } = job;
  return { level, blockCells, bandBegin, bandEnd, cells, checksum };
}
