import { CameraMotion } from "../../viewer/camera_motion.ts";
import { type AxisView, cameraAlong } from "../../viewer/camera_views.ts";
import { writeCamera } from "../../viewer/setting_text.ts";
import type { Camera } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { UrlState } from "../address/url_state.ts";

/** The camera of a volume page: its initial value, and its smooth moves. */
export class PageCamera {
  readonly #viewer: Viewer;
  readonly #url: UrlState;
  readonly #motion: CameraMotion;
  #moved: Camera | null = null;
  /** The camera that the viewer chose, if the address has none. */
  #first: Camera | null = null;

  /** `changed` is called when the camera has moved. */
  constructor(viewer: Viewer, url: UrlState, changed: () => void) {
    this.#viewer = viewer;
    this.#url = url;
    this.#motion = new CameraMotion(viewer);
    viewer.on("camera", (camera) => {
      this.#moved = camera;
      changed();
    });
  }

  /** The camera after its first move; null before. */
  get moved(): Camera | null {
    return this.#moved;
  }

  /** The camera for opening a volume. Undefined: the viewer chooses. */
  toOpen(keepsView: boolean): Camera | undefined {
    const present = keepsView ? this.#viewer.camera : null;
    return present ?? this.#moved ?? this.#ofAddress;
  }

  /**
   * Called when a volume is open. `requested`: the result of `toOpen`. `before`: `moved` at that
   * time. `isOfScene`: opening a scene has set its camera. Returns whether the viewer shows a
   * camera other than `requested`; always false for a view that was kept.
   */
  opened(
    requested: Camera | undefined,
    before: Camera | null,
    keepsView: boolean,
    isOfScene: boolean,
  ): boolean {
    const shown = this.#viewer.camera;
    if (!requested && isOfScene) this.#moved = null;
    if (!requested && !this.#moved) this.#first = shown;
    if (keepsView || this.#moved !== before || !requested || !shown) return false;
    if (writeCamera(requested) === writeCamera(shown)) return false;
    this.#moved = shown;
    return true;
  }

  get #ofAddress(): Camera | undefined {
    const { camera, projection } = this.#url;
    return camera && projection === "orthographic" ? { ...camera, projection } : camera;
  }

  /** The camera, or the target of its present motion. */
  get resting(): Camera | undefined {
    return this.#motion.target ?? this.#moved ?? this.#viewer.camera ?? this.#ofAddress;
  }

  /** See AddressState.isDefaultCamera. */
  get isDefault(): boolean {
    const camera = this.resting;
    if (!camera || this.#url.camera) return false;
    return this.#defaults.some((each) => isSameCamera(each, camera));
  }

  get #defaults(): Camera[] {
    return [this.#first, this.#viewer.wholeView].filter((each) => each !== null);
  }

  /** Whether the picture shows the whole volume as by default, from whichever side. */
  get isWhole(): boolean {
    const camera = this.resting;
    if (!camera) return false;
    const { projection, ...turned } = camera;
    return this.#defaults.some(({ target, distance }) =>
      isSameCamera({ ...turned, target, distance }, turned),
    );
  }

  to(camera: Camera): void {
    this.#motion.to(camera);
  }

  reset(): void {
    const whole = this.#viewer.wholeView;
    if (whole) this.to(whole);
  }

  fit(): void {
    const { camera, wholeView } = this.#viewer;
    if (!camera || !wholeView) return;
    const { target, distance } = wholeView;
    this.to({ ...camera, target, distance });
  }

  /** The volume has changed its size: shows the whole one from the same side. */
  refit(): void {
    const { camera, wholeView } = this.#viewer;
    if (!camera || !wholeView) return;
    const { target, distance } = wholeView;
    this.#viewer.setCamera({ ...camera, target, distance });
  }

  /** Picks the surface at a position in the window, and makes this point the centre of rotation. */
  centre({ clientX, clientY }: { clientX: number; clientY: number }): void {
    const { camera, canvas } = this.#viewer;
    const box = canvas.getBoundingClientRect();
    const point = this.#viewer.pick(clientX - box.left, clientY - box.top);
    if (point && camera) this.to({ ...camera, target: point.position });
  }

  toggleProjection(): void {
    const isOrthographic = this.#viewer.camera?.projection === "orthographic";
    this.#viewer.setProjection(isOrthographic ? "perspective" : "orthographic");
  }

  lookAlong(view: AxisView): void {
    const { camera } = this.#viewer;
    if (camera) this.to(cameraAlong(camera, view));
  }
}

function isSameCamera(a: Camera, b: Camera): boolean {
  const isOrthographic = ({ projection }: Camera) => projection === "orthographic";
  return writeCamera(a) === writeCamera(b) && isOrthographic(a) === isOrthographic(b);
}
