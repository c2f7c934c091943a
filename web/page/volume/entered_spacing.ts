import type { StoreInfo, Triple } from "../../core/types.ts";
import { readMeasurement, writeMeasurement } from "../../measure/measurement_text.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import type { Source } from "../../stream/source.ts";
import { respacing } from "../../viewer/respacing.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { UrlState } from "../address/url_state.ts";
import type { LoadedParts } from "./loaded_parts.ts";

/** Followed by the content id of a store, in localStorage: the spacing that the visitor has entered for it. */
const keptKey = "isosplat-spacing-";

/**
 * Opens the source with the spacing of the address, or the one that was entered on this device before, if the
 * volume's file states none.
 */
export function takeSpacing(source: Source, url: UrlState): void {
  source.spacingOf = (info) =>
    unitOf(info) === "voxel" ? (url.spacing ?? keptSpacing(info)) : undefined;
}

/** The distances between voxels that the visitor enters for a volume whose file states none. */
export class EnteredSpacing {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #parts: Pick<LoadedParts, "measure">;
  readonly #reopen: () => void;

  /** `reopen`: opens the volume again, with the spacing in the address and the present view. */
  constructor(
    viewer: Viewer,
    url: UrlState,
    parts: Pick<LoadedParts, "measure">,
    reopen: () => void,
  ) {
    this.#viewer = viewer;
    this.#url = url;
    this.#parts = parts;
    this.#reopen = reopen;
  }

  /** Asks for the spacing. Camera, planes and measurements move along with the voxels. */
  async enter(): Promise<void> {
    const viewer = this.#viewer;
    const { info } = viewer;
    if (!info) return;
    const { askSpacing } = await import("../panel/spacing_dialog.ts");
    const spacing = await askSpacing(info);
    if (!spacing || viewer.info !== info) return;
    const { point, plane, camera } = respacing(info, spacing);
    const { clip, slices } = viewer;
    viewer.setClip({ ...clip, planes: clip.planes.map(plane) });
    if (slices.plane) viewer.setSlices({ ...slices, plane: plane(slices.plane) });
    if (viewer.camera) viewer.setCamera(camera(viewer.camera));
    const lines = this.#parts.measure?.lines ?? this.#url.measures;
    const moved = lines?.map((line) => movedLine(line, point));
    if (moved && this.#parts.measure) this.#parts.measure.restore(moved);
    else if (moved) this.#url.measures = moved;
    this.#url.spacing = spacing;
    keepSpacing(info, spacing);
    this.#reopen();
  }
}

function movedLine(line: string, point: (position: Triple) => Triple): string {
  const measurement = readMeasurement(line);
  if (!measurement) return line;
  const points = measurement.points.map((each) => ({ ...each, position: point(each.position) }));
  return writeMeasurement({ ...measurement, points });
}

function keepSpacing({ contentId }: StoreInfo, spacing: Triple): void {
  try {
    localStorage.setItem(keptKey + contentId, spacing.join(","));
  } catch {
    // Storage may be full or disabled. The address has the spacing.
  }
}

function keptSpacing({ contentId }: StoreInfo): Triple | undefined {
  try {
    const [x = 0, y = 0, z = 0] = (localStorage.getItem(keptKey + contentId) ?? "")
      .split(",")
      .map(Number);
    return x > 0 && y > 0 && z > 0 ? [x, y, z] : undefined;
  } catch {
    return undefined; // storage may be disabled
  }
}
