/** A worker that encodes blocks for the director at the other side of a port. */
import type { CompiledModule } from "../core/instantiate.ts";
import { type Port, serveEncoder } from "./encoder_port.ts";

/** The only message. */
export interface EncodeWorkerStart {
  port: Port;
  program: CompiledModule;
}

const worker = globalThis as unknown as {
  onmessage: ((event: MessageEvent<EncodeWorkerStart>) => void) | null;
};

worker.onmessage = ({ data }) => serveEncoder(data.port, data.program);
