import type { StoreInfo } from "../../core/types.ts";
import { defaultCoarseBytes } from "../../stream/coarse_tail.ts";
import { KeptSource } from "../../stream/kept_source.ts";
import type { StoreAccess } from "../../stream/session_parts.ts";
import type { Source } from "../../stream/source.ts";
import { defaultLook, type Look } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { savesData, whenDrawn, withHiddenViewer } from "../shell/hidden_viewer.ts";

/** In CSS pixels. */
const size = { width: 96, height: 72 };
/** The pictures begin when the view has rested for this time (ms): a visitor often moves on at once. */
const rest = 1000;
const longest = { firstSurface: 5000, refining: 1000 };
/** The camera is closer than in the view of the whole volume, since surfaces seldom reach its corners. */
const zoom = 1.25;

const maxRatio = 2;
/** Cells of this size (pixels) are fine enough. */
const finest = 1.2;
/** The nearest cells of a view are larger than those in its middle, by less than this factor. */
const nearer = 1.6;

/**
 * Cheap splats without ambient occlusion and shadows. The surfaces are white: the page's style multiplies them
 * by the colour of the visitor's surface.
 */
const look: Look = {
  ...defaultLook,
  kind: "ellipse",
  shading: "smooth",
  light: { ...defaultLook.light, occlusion: 0, shadow: 0 },
};

/** The volume whose pictures are shown. */
export interface PicturedVolume {
  info: StoreInfo;
  isovalues: readonly number[];
  /** The store of the session that shows the volume; undefined while there is none. */
  access(): StoreAccess | undefined;
}

export interface IsovaluePicturesHost {
  /** Whether the view is complete and rests, and the pictures are in view. */
  mayDraw(): boolean;
  /** There is a new picture, or there will be none: `pictureOf`, `arePossible`. */
  changed(): void;
}

/**
 * Draws a small picture of each offered isovalue from levels of the store that the session of the volume has
 * loaded already. Another viewer draws them, so that the picture of the page does not change. It
 * exists only while it draws. A change of the view interrupts it; it continues when the view rests again.
 * Pictures are kept as long as the page.
 */
export class IsovaluePictures {
  readonly #host: IsovaluePicturesHost;
  /** Blob URLs, by `keyOf`. */
  readonly #pictures = new Map<string, string>();
  /** The content ids of stores whose pictures could not be drawn. */
  readonly #failed = new Set<string>();
  #volume: PicturedVolume | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #drawing: AbortController | null = null;

  constructor(host: IsovaluePicturesHost) {
    this.#host = host;
    document.addEventListener("visibilitychange", this.#shown);
  }

  readonly #shown = () => this.update(this.#volume);

  /** The URL of a picture; undefined until it is drawn. */
  pictureOf(info: StoreInfo, isovalue: number): string | undefined {
    return this.#pictures.get(keyOf(info, isovalue));
  }

  /** Whether there are pictures of this volume, or will be. There is no choice between fewer than two. */
  arePossible({ contentId }: StoreInfo, isovalues: readonly number[]): boolean {
    return isovalues.length > 1 && !savesData() && !this.#failed.has(contentId);
  }

  /** Call it when the volume, or anything that `mayDraw` depends on, may have changed. */
  update(volume: PicturedVolume | null): void {
    const storeOf = (shown: PicturedVolume | null) => shown && keyOf(shown.info, 0);
    const isOther = storeOf(volume) !== storeOf(this.#volume);
    this.#volume = volume;
    if (isOther || !this.#host.mayDraw()) this.stop();
    const isWaiting = this.#timer !== undefined || this.#drawing !== null;
    if (!isWaiting && this.#missing().length > 0 && this.#host.mayDraw()) {
      this.#timer = setTimeout(() => {
        this.#timer = undefined;
        void this.#draw();
      }, rest);
    }
  }

  /** Stops drawing. Pictures that are drawn already stay. */
  stop(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#drawing?.abort();
    this.#drawing = null;
  }

  /** Frees the pictures. */
  close(): void {
    this.stop();
    document.removeEventListener("visibilitychange", this.#shown);
    this.#volume = null;
    for (const url of this.#pictures.values()) URL.revokeObjectURL(url);
    this.#pictures.clear();
  }

  /** The isovalues without a picture. */
  #missing(): number[] {
    if (!this.#volume) return [];
    const { info, isovalues } = this.#volume;
    if (!this.arePossible(info, isovalues)) return [];
    return isovalues.filter((isovalue) => this.pictureOf(info, isovalue) === undefined);
  }

  async #draw(): Promise<void> {
    const volume = this.#volume;
    const access = volume?.access();
    const isovalues = this.#missing();
    if (!volume || !access || isovalues.length === 0 || !this.#host.mayDraw()) return;
    const drawing = new AbortController();
    this.#drawing = drawing;
    const { signal } = drawing;
    const { source } = access;
    const { contentId } = volume.info;
    const options = {
      maxPixelRatio: maxRatio,
      targetCellPixels: cellPixels(volume.info, access, isovalues),
      backgroundBytes: 0,
      readAheadBytes: 0,
    };
    try {
      await withHiddenViewer(size, options, async (viewer) => {
        viewer.setLook(look);
        for (const isovalue of isovalues) {
          const picture = await pictureAt(viewer, source, contentId, isovalue, signal);
          signal.throwIfAborted();
          if (!picture) throw new Error("the surface could not be drawn in time");
          this.#pictures.set(keyOf(volume.info, isovalue), URL.createObjectURL(picture));
          this.#host.changed();
        }
      });
    } catch {
      // The buttons show their numbers instead.
      if (!signal.aborted) this.#failed.add(contentId);
    }
    if (this.#drawing === drawing) this.#drawing = null;
    if (!signal.aborted) this.#host.changed();
  }
}

/**
 * The size of cells on the screen (pixels) up to which they are not refined, so that only what is loaded already
 * is needed.
 */
function cellPixels(
  { voxels, spacing }: StoreInfo,
  access: StoreAccess,
  isovalues: readonly number[],
): number {
  // The first view shows the sphere around the volume.
  const diameter = Math.hypot(...voxels.map((count, axis) => count * (spacing[axis] ?? 1)));
  const cell = 2 ** finestLoadedLevel(access, isovalues) * Math.max(...spacing);
  const pixels = (cell / diameter) * size.height * zoom * Math.min(devicePixelRatio, maxRatio);
  return Math.max(finest, nearer * pixels);
}

/** The finest level that needs no request for these isovalues: of the coarse tail, or of chunks that are kept. */
function finestLoadedLevel({ source, store }: StoreAccess, isovalues: readonly number[]): number {
  if (source.isLocal) return 0;
  const { firstLevel } = store.coarseRange(defaultCoarseBytes);
  let level = Math.min(firstLevel, store.bootstrapRange().firstLevel);
  if (!(source instanceof KeptSource)) return level;
  const isKept = (finer: number) =>
    isovalues.every(
      (isovalue) =>
        store.missingPages(finer, isovalue).length === 0 &&
        store.chunksFor(finer, isovalue).every((chunk) => source.has(chunk)),
    );
  while (level > 0 && isKept(level - 1)) --level;
  return level;
}

/** The visitor may enter another spacing for the same store. */
function keyOf({ contentId, spacing }: StoreInfo, isovalue: number): string {
  return `${contentId} ${spacing} ${isovalue}`;
}

/** A PNG without background. Undefined if it cannot be drawn in time. Rejects with the signal's reason. */
async function pictureAt(
  viewer: Viewer,
  source: Source,
  contentId: string,
  isovalue: number,
  signal: AbortSignal,
): Promise<Blob | undefined> {
  const picture = whenDrawn(viewer, longest);
  signal.addEventListener("abort", picture.stop, { once: true });
  try {
    const surfaces = [{ isovalue, colour: "#ffffff", opacity: 1 }];
    if (viewer.info) {
      viewer.setSurfaces(surfaces);
    } else {
      const info = await viewer.open(source, { surfaces, signal });
      if (info.contentId !== contentId) return undefined; // the volume was replaced
      if (viewer.camera) {
        viewer.setCamera({ ...viewer.camera, distance: viewer.camera.distance / zoom });
      }
    }
    if (!(await picture.drawn) || signal.aborted) return undefined;
    return await viewer.screenshot({ smooth: false, transparent: true });
  } finally {
    signal.removeEventListener("abort", picture.stop);
    picture.stop();
  }
}
