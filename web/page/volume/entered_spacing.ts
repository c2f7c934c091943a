import type { StoreInfo, Triple } from "../../core/types.ts";
import { readMeasurement, writeMeasurement } from "../../measure/measurement_text.ts";
import { movedMeasurement } from "../../measure/moved_measurement.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import type { Source } from "../../stream/source.ts";
import { respacing } from "../../viewer/respacing.ts";
import { sameValue } from "../../viewer/same_value.ts";
import type { Camera } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { UrlState } from "../address/url_state.ts";
import { inUnit, millimetresOf, type UnitSpacing } from "../panel/spacing_units.ts";
import { forgetSpacing, keepSpacing, keptSpacing } from "./kept_spacing.ts";
import type { LoadedParts } from "./loaded_parts.ts";

/**
 * Opens the source with the spacing of the address, or the one that was entered on this device before, if the
 * volume's file states none.
 */
export function takeSpacing(source: Source, url: UrlState): void {
  source.spacingOf = (info) =>
    unitOf(info) === "voxel"
      ? (url.spacing ?? millimetres(keptSpacing(info.contentId)))
      : undefined;
}

function millimetres(entered: UnitSpacing | undefined): Triple | undefined {
  return entered && millimetresOf(entered);
}

export interface EnteredSpacingHost {
  /** A view that has not come to rest is a step of undo as well. */
  rest(): void;
  /** Opens the volume again, with the spacing in the address and the present view. */
  reopen(): Promise<void>;
  /** Shows the whole volume, unless the address states a camera. */
  refit(): void;
  /** The volume is open with the other spacing. */
  changed(): void;
}

/** The distances between voxels that the visitor enters for a volume whose file states none. */
export class EnteredSpacing {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #parts: Pick<LoadedParts, "measure">;
  readonly #host: EnteredSpacingHost;
  /** What the visitor has entered, by the distances in mm, since undo and redo have no units. */
  readonly #entered = new Map<string, UnitSpacing>();
  #changing: Promise<void> | null = null;

  constructor(
    viewer: Viewer,
    url: UrlState,
    parts: Pick<LoadedParts, "measure">,
    host: EnteredSpacingHost,
  ) {
    this.#viewer = viewer;
    this.#url = url;
    this.#parts = parts;
    this.#host = host;
  }

  /** Whether the volume is being opened with another spacing: camera, planes and measurements do not fit it yet. */
  get isChanging(): boolean {
    return this.#changing !== null;
  }

  /** Calls `action` after the present change. Returns false if there is none. */
  postpones(action: () => void): boolean {
    void this.#changing?.then(action);
    return this.isChanging;
  }

  /** Asks for the spacing. Camera, planes and measurements move along with the voxels. */
  async enter(): Promise<void> {
    const { info } = this.#viewer;
    if (!info) return;
    const { askSpacing } = await import("../panel/spacing_dialog.ts");
    const answer = await askSpacing(this.#shown(info), info.isSpacingGiven === true);
    if (!answer || this.#viewer.info !== info) return;
    const entered = answer === "unknown" ? undefined : answer;
    const spacing = millimetres(entered);
    if (entered) {
      this.#entered.set(String(spacing), entered);
      keepSpacing(info.contentId, entered);
    }
    if (info.isSpacingGiven && sameValue(spacing, info.spacing)) return;
    this.#host.rest();
    await this.#change(spacing, info, () => {
      this.#moveTo(spacing ?? info.statedSpacing ?? [1, 1, 1], info);
      return () => this.#host.refit();
    });
  }

  /** Restores the spacing and the camera of an earlier view, for undo and redo. Returns false if it has not changed. */
  restore(spacing: Triple | undefined, camera: Camera): boolean {
    const { info } = this.#viewer;
    if (!info || sameValue(spacing, info.isSpacingGiven && info.spacing)) return false;
    if (spacing) {
      keepSpacing(info.contentId, this.#entered.get(String(spacing)) ?? inUnit(spacing));
    }
    const setCamera = () => this.#viewer.setCamera(camera);
    void this.#change(spacing, info, () => {
      setCamera();
      return setCamera; // the other volume has other limits
    });
    return true;
  }

  /** What the dialog shows first: what the visitor has entered, in its unit. */
  #shown({ contentId, spacing, isSpacingGiven }: StoreInfo): UnitSpacing {
    const kept = keptSpacing(contentId);
    if (isSpacingGiven && sameValue(millimetres(kept), spacing)) return kept ?? inUnit(spacing);
    return isSpacingGiven ? inUnit(spacing) : { lengths: spacing, unit: "mm" };
  }

  /** `move`: changes the view before the volume is opened again. Returns what to do afterwards. */
  async #change(
    spacing: Triple | undefined,
    { contentId }: StoreInfo,
    move: () => () => void,
  ): Promise<void> {
    const change = async () => {
      const finish = move();
      if (spacing) this.#url.spacing = spacing;
      else {
        delete this.#url.spacing;
        forgetSpacing(contentId);
      }
      await this.#host.reopen();
      finish();
    };
    this.#changing = change().finally(() => {
      this.#changing = null;
      this.#host.changed();
    });
    await this.#changing;
  }

  #moveTo(spacing: Triple, info: StoreInfo): void {
    const viewer = this.#viewer;
    const change = respacing(info, spacing);
    const { clip, slices } = viewer;
    viewer.setClip({ ...clip, planes: clip.planes.map(change.plane) });
    if (slices.plane) viewer.setSlices({ ...slices, plane: change.plane(slices.plane) });
    if (viewer.camera) viewer.setCamera(change.camera(viewer.camera));
    const { measure } = this.#parts;
    if (measure) measure.respace(change);
    else if (this.#url.measures) {
      this.#url.measures = this.#url.measures.map((line) => {
        const measurement = readMeasurement(line);
        return measurement ? writeMeasurement(movedMeasurement(measurement, change)) : line;
      });
    }
  }
}
