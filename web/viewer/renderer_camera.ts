import * as layouts from "../../build/wasm/web/layouts.js";
import type { RendererInstance } from "./renderer_instance.ts";
import type { Camera, Projection } from "./types.ts";

function flagOf(projection: Projection | undefined): number {
  return projection === "orthographic" ? 1 : 0;
}

const noCamera = {
  target: [0, 0, 0],
  distance: 1,
  azimuth: 0,
  elevation: 0,
  roll: 0,
  fieldOfView: 30,
} satisfies Camera;

/** Writes a camera to `scratch`, as the record that calls expect. */
export function writeCamera(instance: RendererInstance, camera: Camera): void {
  const orthographic = flagOf(camera.projection);
  layouts.writeCamera(instance.view(), instance.scratch, { ...camera, orthographic });
}

function readCamera(instance: RendererInstance): Camera {
  const { orthographic, ...camera } = layouts.readCamera(instance.view(), instance.scratch);
  return orthographic ? { ...camera, projection: "orthographic" } : camera;
}

/**
 * Views of a renderer's volumes: limits, the first view, moves and projection. These functions do
 * not change the picture: RendererPicture.setCamera does.
 */
export class RendererCamera {
  readonly #instance: RendererInstance;

  constructor(instance: RendererInstance) {
    this.#instance = instance;
  }

  /** The camera of the first picture. `aspect`: width / height of the image. */
  defaultCamera(aspect: number, projection?: Projection): Camera {
    const data = this.#instance.view();
    layouts.writeCamera(data, this.#instance.scratch, {
      ...noCamera,
      orthographic: flagOf(projection),
    });
    this.#instance.exports._isosplat_renderer_default_camera(this.#instance.scratch, aspect);
    return readCamera(this.#instance);
  }

  orbited(camera: Camera, rightDegrees: number, upDegrees: number): Camera {
    writeCamera(this.#instance, camera);
    this.#instance.exports._isosplat_renderer_orbit(
      this.#instance.scratch,
      rightDegrees,
      upDegrees,
    );
    return readCamera(this.#instance);
  }

  panned(camera: Camera, rightPx: number, downPx: number, imageHeightPx: number): Camera {
    writeCamera(this.#instance, camera);
    this.#instance.exports._isosplat_renderer_pan(
      this.#instance.scratch,
      rightPx,
      downPx,
      imageHeightPx,
    );
    return readCamera(this.#instance);
  }

  zoomed(camera: Camera, factor: number): Camera {
    writeCamera(this.#instance, camera);
    this.#instance.exports._isosplat_renderer_zoom(this.#instance.scratch, factor);
    return readCamera(this.#instance);
  }

  /** A valid camera: this one, or the nearest valid one if its numbers are out of range. */
  bounded(camera: Camera): Camera {
    writeCamera(this.#instance, camera);
    this.#instance.exports._isosplat_renderer_bound(this.#instance.scratch);
    return readCamera(this.#instance);
  }

  /** World to clip space: a matrix of 4 × 4, column by column. */
  viewProjection(camera: Camera, width: number, height: number): Float64Array {
    writeCamera(this.#instance, camera);
    const at = this.#instance.scratch + layouts.cameraBytes;
    this.#instance.exports._isosplat_renderer_projection(this.#instance.scratch, width, height, at);
    return Float64Array.from(layouts.readProjection(this.#instance.view(), at).clipFromWorld);
  }
}
