import { cameraBetween } from "./camera_views.ts";
import type { Camera } from "./types.ts";
import type { Viewer } from "./viewer.ts";

/** Duration of a motion (ms). */
const duration = 350;

/**
 * Moves the camera of a viewer smoothly to another one. Any other change of the camera ends the
 * motion. Visitors who prefer reduced motion see the other view at once.
 */
export class CameraMotion {
  readonly #viewer: Viewer;
  #handle = 0;
  #target: Camera | null = null;
  #isSetting = false;

  constructor(viewer: Viewer) {
    this.#viewer = viewer;
    viewer.on("camera", () => {
      if (!this.#isSetting) this.stop();
    });
  }

  /** The camera at the end of the present motion; null if there is none. */
  get target(): Camera | null {
    return this.#target;
  }

  to(camera: Camera): void {
    this.stop();
    const from = this.#viewer.camera;
    if (!from || matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.#set(camera);
      return;
    }
    this.#target = camera;
    const begin = performance.now();
    const step = (now: number): void => {
      const time = Math.max(0, Math.min(1, (now - begin) / duration));
      if (time === 1) this.#target = null;
      // Smoothstep: begins and ends slowly.
      this.#set(cameraBetween(from, camera, time * time * (3 - 2 * time)));
      this.#handle = time < 1 ? requestAnimationFrame(step) : 0;
    };
    this.#handle = requestAnimationFrame(step);
  }

  stop(): void {
    cancelAnimationFrame(this.#handle);
    this.#handle = 0;
    this.#target = null;
  }

  #set(camera: Camera): void {
    this.#isSetting = true;
    this.#viewer.setCamera(camera);
    this.#isSetting = false;
  }
}
