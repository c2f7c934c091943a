import { FileSource, type SourceOptions } from "./file_source.ts";
import { transferWhole } from "./transfer.ts";
import { StreamError } from "./types.ts";

export interface SiteSourceOptions extends SourceOptions {
  /** The address of the site's catalog, `catalog.json`. */
  catalog: string;
  /** The volume's name in the catalog. */
  volume: string;
}

/**
 * A volume of a static site, which `isosplat publish` writes. The catalog names the file of the
 * volume's store. When a volume is published again, it gets a new file; files never change.
 */
export class SiteSource extends FileSource {
  readonly #catalogUrl: string;
  #fileUrl: string | undefined;

  constructor(options: SiteSourceOptions) {
    super(options.volume, options);
    const page = typeof location === "undefined" ? undefined : location.href;
    this.#catalogUrl = new URL(options.catalog, page).href;
  }

  /** Undefined until the catalog has been read. */
  override get address(): string | undefined {
    return this.#fileUrl;
  }

  override forget(): void {
    super.forget();
    this.#fileUrl = undefined;
  }

  override async contentId(signal: AbortSignal): Promise<string> {
    return (await this.#entry(signal, true)).contentId;
  }

  protected override async fetchHeader(signal: AbortSignal, whole: boolean): Promise<Uint8Array> {
    const { file } = await this.#entry(signal, this.fresh);
    this.#fileUrl = new URL(file, this.#catalogUrl).href;
    return super.fetchHeader(signal, whole);
  }

  protected override fileUrl(): string {
    return this.#fileUrl ?? this.#catalogUrl;
  }

  async #entry(signal: AbortSignal, fresh: boolean): Promise<PublishedVolume> {
    const answer = await transferWhole(this.#catalogUrl, { fresh }, this.traffic, signal);
    const volume = readCatalog(answer, this.#catalogUrl).find(({ name }) => name === this.name);
    if (volume) return volume;
    throw new StreamError("not-found", `${this.#catalogUrl}: has no volume ${this.name}`);
  }
}

/** An entry of the catalog; its other fields are those of server/HTTP.md. */
interface PublishedVolume {
  name: string;
  /** The store's address, relative to the catalog. */
  file: string;
  contentId: string;
}

function readCatalog(answer: Uint8Array, url: string): PublishedVolume[] {
  try {
    const { volumes } = JSON.parse(new TextDecoder().decode(answer)) as {
      volumes: PublishedVolume[];
    };
    const isComplete = volumes.every(({ name, file, contentId }) =>
      [name, file, contentId].every((text) => typeof text === "string"),
    );
    if (isComplete) return volumes;
  } catch {} // reported below
  throw new StreamError(
    "server-fault",
    `${url}: expected the catalog of a site from isosplat publish, found something else`,
  );
}
