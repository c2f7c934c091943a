import { FileSource, hexadecimal, type SourceOptions } from "../stream/file_source.ts";
import { transferWhole } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";

export interface ServedSceneOptions extends SourceOptions {
  /** The server's address. Default: the page's address. */
  base?: string;
  /** The scene's name on the server. */
  scene: string;
}

/**
 * A scene of an Isosplat server (server/HTTP.md), which serves every scene as a bundle. The address of the bundle
 * contains the checksum of its header, so the content at this address never changes.
 */
export class ServedBundle extends FileSource {
  readonly #sceneUrl: string;
  #contentUrl: string | undefined;

  constructor(options: ServedSceneOptions) {
    super(options.scene, options);
    const page = typeof location === "undefined" ? undefined : location.href;
    const base = new URL(options.base ?? ".", page).href.replace(/\/*$/, "/");
    this.#sceneUrl = `${base}v1/scenes/${encodeURIComponent(options.scene)}`;
  }

  override get address(): string {
    return this.#sceneUrl;
  }

  /** The header, and coarse parts of stores: everything for the first picture. */
  override async firstBytes(_count: number, signal: AbortSignal): Promise<Uint8Array> {
    const url = `${this.#sceneUrl}/bootstrap`;
    const bytes = await transferWhole(url, { fresh: this.fresh }, this.traffic, signal);
    const end = headerBytesOf(bytes);
    if (bytes.length < Math.max(end, 72)) {
      throw new StreamError(
        "server-fault",
        `${url}: expected the header of a bundle, found ${bytes.length} bytes`,
      );
    }
    const checksum = hexadecimal(bytes.slice(end - 8, end).reverse());
    this.#contentUrl = `${this.#sceneUrl}/${checksum}/file`;
    return bytes;
  }

  override forget(): void {
    super.forget();
    this.#contentUrl = undefined;
  }

  protected override fileUrl(): string {
    return this.#contentUrl ?? this.#sceneUrl;
  }
}

/** Reads the size of a bundle's header, which follows the magic number and the version. */
function headerBytesOf(bytes: Uint8Array): number {
  if (bytes.length < 16) return 0;
  return new DataView(bytes.buffer, bytes.byteOffset).getUint32(12, true);
}
