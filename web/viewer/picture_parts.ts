import { RendererError } from "./renderer_error.ts";
import type { RendererModule } from "./renderer_module.ts";
import type { Camera, Look, PartsOptions, PictureInParts, PictureSize } from "./types.ts";

/** The functions that a picture in parts needs from its viewer. */
export interface PictureInPartsHost {
  /** Runs an action of the renderer; returns whether it succeeded. */
  guard(action: (renderer: RendererModule) => void): boolean;
  isContextLost(): boolean;
  /** Sets the opacity of the background. */
  setOpacity(renderer: RendererModule, opacity: number): void;
  /** The picture has ended: the canvas may be drawn again. */
  ended(): void;
}

/** Begins a picture in parts: see Viewer.beginPicture. Throws a RendererError, after `ended`. */
export function beginPictureInParts(
  { width, height }: PictureSize,
  camera: Camera,
  { kind, shading }: Readonly<Look>,
  { transparent, pictures }: Required<PartsOptions>,
  host: PictureInPartsHost,
): PictureInParts {
  const must = (action: (renderer: RendererModule) => void): void => {
    if (host.isContextLost() || !host.guard(action)) {
      throw new RendererError("the GPU could not draw the picture: try a smaller one");
    }
  };
  let hasEnded = false;
  const end = (): void => {
    if (hasEnded) return;
    hasEnded = true;
    host.guard((renderer) => {
      renderer.endTiles();
      host.setOpacity(renderer, 1);
    });
    host.ended();
  };
  try {
    must((renderer) => {
      renderer.picture.setCamera(camera);
      renderer.picture.setSplats({ kind: kind === "automatic" ? "exact" : kind, shading });
      host.setOpacity(renderer, transparent ? 0 : 1);
      renderer.beginTiles(width, height);
    });
  } catch (error) {
    end();
    throw error;
  }
  const draw = (x: number, y: number, partWidth: number, partHeight: number) => {
    let part = new Uint8ClampedArray();
    must((renderer) => {
      part = renderer.drawTile(x, y, partWidth, partHeight, pictures);
    });
    return part;
  };
  return { width, height, draw, end };
}

/**
 * The canvas as a PNG. Call it in the task that has drawn the canvas: the browser may clear it
 * afterwards.
 */
export function pngOf(canvas: HTMLCanvasElement): Promise<Blob> {
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => {
      if (blob) resolve(blob);
      else reject(new RendererError("the browser made no picture of the canvas"));
    }, "image/png"),
  );
}
