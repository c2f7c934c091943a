import type { FrameScheduler } from "./frame_scheduler.ts";
import { beginPictureInParts, pngOf } from "./picture_parts.ts";
import { RendererError } from "./renderer_error.ts";
import type { RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import type { Scene, SceneLayer } from "./scene.ts";
import type { Camera, Look, PartsOptions, PictureInParts, PictureView } from "./types.ts";

/** The functions that pictures need from their viewer. */
export interface SavedPicturesHost {
  /** Null before the first renderer. */
  scheduler(): FrameScheduler | null;
  camera(): Camera | null;
  /** A volume is open. */
  isOpen(): boolean;
  look(): Readonly<Look>;
  /** `opacity`: of the background. */
  applyLook(renderer: RendererModule, opacity: number): void;
}

/** Pictures of a viewer that are saved: as the canvas shows it, or with another size and view. */
export class SavedPictures {
  readonly #canvas: HTMLCanvasElement;
  readonly #life: RendererLife;
  readonly #host: SavedPicturesHost;
  #prepared: PictureView | null = null;
  #isInParts = false;

  constructor(canvas: HTMLCanvasElement, life: RendererLife, host: SavedPicturesHost) {
    this.#canvas = canvas;
    this.#life = life;
    this.#host = host;
  }

  /** What is drawn next; null if nothing can be drawn. */
  scene(layers: () => SceneLayer[]): Scene | null {
    const camera = this.#prepared?.camera ?? this.#host.camera();
    const canDraw = this.#life.renderer && !this.#life.isContextLost && !this.#isInParts;
    if (!canDraw || !camera || !this.#host.isOpen()) return null;
    const { kind, shading } = this.#host.look();
    return { layers: layers(), camera, kind, shading, pictureSize: this.#prepared };
  }

  /** Viewer.screenshot. */
  async screenshot({ smooth = true, transparent = false }): Promise<Blob> {
    const scheduler = this.#host.scheduler();
    if (!scheduler || this.#life.isContextLost) throw new RendererError("nothing is drawn yet");
    const setOpacity = (opacity: number) =>
      this.#life.guard((renderer) => this.#host.applyLook(renderer, opacity));
    if (transparent) setOpacity(0);
    try {
      scheduler.drawToSave(smooth);
      // This copies the picture at once, so later draws with a background do not change it.
      return pngOf(this.#canvas);
    } finally {
      if (transparent) {
        setOpacity(1);
        scheduler.request();
      }
    }
  }

  /** Viewer.preparePicture. */
  prepare(view: PictureView | null): void {
    this.#prepared = view;
    this.#host.scheduler()?.onCameraChange();
  }

  /** Viewer.beginPicture. */
  begin({ transparent = false, pictures = 8 }: PartsOptions): PictureInParts {
    const camera = this.#prepared?.camera ?? this.#host.camera();
    if (!camera || !this.#host.isOpen() || this.#life.isContextLost) {
      throw new RendererError("nothing is drawn yet");
    }
    this.#isInParts = true;
    const size = this.#prepared ?? this.#canvas;
    const options = { transparent, pictures };
    return beginPictureInParts(size, camera, this.#host.look(), options, {
      guard: (action) => this.#life.guard(action),
      isContextLost: () => this.#life.isContextLost,
      setOpacity: (renderer, opacity) => this.#host.applyLook(renderer, opacity),
      ended: () => {
        this.#isInParts = false;
        this.#host.scheduler()?.onCameraChange();
      },
    });
  }
}
