import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import { failureOf, type WorkerFailure } from "../core/worker_failure.ts";
import { Builder } from "./builder.ts";
import type { Encoder } from "./direct.ts";
import { instantiateBuilder } from "./module.ts";

/** The part of a MessagePort that is used here. */
export interface Port {
  onmessage: ((event: MessageEvent) => void) | null;
  postMessage(message: unknown, transfer: Transferable[]): void;
}

type Request = { id: number } & (
  | { setup: Uint8Array }
  | { task: Uint8Array }
  | { wantsStatistics: true }
);
type Response = { id: number } & ({ bytes: Uint8Array } | WorkerFailure);

/** Handles the requests of a PortEncoder with a local encoder. For the worker's side of a port. */
export function serveEncoder(port: Port, program: CompiledModule): void {
  const builder = instantiateBuilder(program).then((module) => new Builder(module));
  builder.catch(() => {}); // each request reports the error
  const answer = async (request: Request): Promise<Uint8Array> => {
    const encoder = await builder;
    if ("task" in request) return encoder.encode(request.task);
    if ("wantsStatistics" in request) return encoder.statistics();
    encoder.setUp(request.setup);
    return new Uint8Array();
  };
  port.onmessage = async ({ data }: MessageEvent<Request>) => {
    try {
      const bytes = await answer(data);
      const response: Response = { id: data.id, bytes };
      port.postMessage(response, [bytes.buffer as ArrayBuffer]);
    } catch (error) {
      // WebAssembly that has aborted cannot be used again, and the build cannot continue without it.
      port.postMessage({ id: data.id, ...failureOf(error) } satisfies Response, []);
    }
  };
}

/** An encoder at the other side of a port. */
export class PortEncoder implements Encoder {
  readonly #port: Port;
  readonly #requests = new Map<
    number,
    { resolve(bytes: Uint8Array): void; reject(reason: unknown): void }
  >();
  #nextId = 0;

  constructor(port: Port) {
    this.#port = port;
    port.onmessage = ({ data }: MessageEvent<Response>) => {
      const request = this.#requests.get(data.id);
      this.#requests.delete(data.id);
      if ("bytes" in data) request?.resolve(data.bytes);
      else request?.reject(new CoreError(data.status, data.message));
    };
  }

  async setUp(setup: Uint8Array): Promise<void> {
    await this.#ask({ setup }, []);
  }

  encode(task: Uint8Array): Promise<Uint8Array> {
    return this.#ask({ task }, [task.buffer as ArrayBuffer]);
  }

  statistics(): Promise<Uint8Array> {
    return this.#ask({ wantsStatistics: true }, []);
  }

  /** Rejects all pending requests, because the worker was lost. */
  fail(reason: unknown): void {
    for (const request of this.#requests.values()) request.reject(reason);
    this.#requests.clear();
  }

  #ask(request: object, transfer: Transferable[]): Promise<Uint8Array> {
    const id = this.#nextId++;
    return new Promise((resolve, reject) => {
      this.#requests.set(id, { resolve, reject });
      this.#port.postMessage({ id, ...request }, transfer);
    });
  }
}
