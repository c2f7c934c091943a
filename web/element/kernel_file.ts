import type { SlicedFile } from "../stream/blob_source.ts";
import { StreamError } from "../stream/types.ts";

/** The messages of an AFM model between a view and the kernel. */
export interface KernelMessages {
  send(content: unknown): void;
  on(event: "msg:custom", listener: MessageListener): void;
  off(event: "msg:custom", listener: MessageListener): void;
}

type MessageListener = (content: unknown, buffers?: readonly ArrayBufferView[]) => void;

/** A kernel answers when its present cell has ended. Later, the request may have been lost (ms). */
const longestWait = 60_000;

/** No two requests of a page have the same number, since all views of a model receive all answers. */
let requests = 0;

/**
 * A file of `size` bytes that the kernel reads: each slice is a request {kind: "read", id, offset, bytes}, which is
 * answered by {kind: "read", id} with one buffer, or {kind: "read", id, error}. Slices reject with the fault
 * `unreachable` if there is no answer for a minute.
 */
export function kernelFile(model: KernelMessages, size: number): SlicedFile {
  return {
    size,
    slice: (start, end) => ({ arrayBuffer: () => read(model, start, end - start) }),
  };
}

function read(model: KernelMessages, offset: number, bytes: number): Promise<ArrayBuffer> {
  const id = `${++requests} ${Math.random()}`;
  return new Promise((resolve, reject) => {
    const end = () => {
      clearTimeout(timer);
      model.off("msg:custom", listen);
    };
    const fail = (reason: string) =>
      reject(new StreamError("unreachable", `the kernel's file: ${reason}`));
    const listen: MessageListener = (content, buffers) => {
      const answer = content as { kind?: unknown; id?: unknown; error?: unknown } | null;
      if (answer?.kind !== "read" || answer.id !== id) return;
      end();
      const [part] = buffers ?? [];
      if (part?.byteLength !== bytes) {
        return fail(`expected ${bytes} bytes, found ${answer.error ?? part?.byteLength}`);
      }
      // A part of a larger message.
      resolve(new Uint8Array(part.buffer, part.byteOffset, bytes).slice().buffer as ArrayBuffer);
    };
    const timer = setTimeout(() => {
      end();
      fail(`expected an answer of the kernel within ${longestWait / 1000} s, found none`);
    }, longestWait);
    model.on("msg:custom", listen);
    model.send({ kind: "read", id, offset, bytes });
  });
}
