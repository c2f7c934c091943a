/** The core in WebAssembly, for Node and browsers. */
export interface Core {
  close(): void;
}

/** Where the core's functions come from: its own module, or a larger one that contains it. */
export interface CoreOptions {
  /** The bytes of isosplat-core.wasm (Node). */
  wasmBinary?: Uint8Array;
  /** The address of isosplat-core.wasm (browser). Default: beside the module. */
  url?: string;
  /** An instance that exports the core's functions, such as isosplat-view. */
  module?: unknown;
}

export declare function loadCore(options?: CoreOptions): Promise<Core>;
