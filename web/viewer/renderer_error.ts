import type { FaultKind } from "../stream/faults.ts";

/** The renderer failed. `message` comes from the C++ renderer. */
export class RendererError extends Error {
  override readonly name = "RendererError";
  readonly kind: FaultKind;
  constructor(message: string, kind: FaultKind = "renderer-failed", cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.kind = kind;
  }
}
