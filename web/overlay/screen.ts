import type { Triple } from "../core/types.ts";
import type { Viewer } from "../viewer/viewer.ts";

/** A point of the picture: CSS pixels from the top left; `depth` > 0 grows away from the eye. */
export interface ScreenPoint {
  x: number;
  y: number;
  depth: number;
}

/**
 * Projects points of the world into a picture. `matrix`: world to clip space, 4 × 4, column by column
 * (Viewer.viewProjection).
 */
export class Screen {
  readonly width: number;
  readonly height: number;
  readonly #matrix: ArrayLike<number>;

  constructor(matrix: ArrayLike<number>, width: number, height: number) {
    this.#matrix = matrix;
    this.width = width;
    this.height = height;
  }

  /** Undefined for points that are not in front of the eye. */
  point(world: Triple): ScreenPoint | undefined {
    const w = this.#row(3, world) + this.#at(3, 3);
    if (!(w > 0)) return undefined;
    const x = (this.#row(0, world) + this.#at(0, 3)) / w;
    const y = (this.#row(1, world) + this.#at(1, 3)) / w;
    // Orthographic: from −1 at the near plane to 1.
    const depth = this.#isOrthographic ? 2 + this.#row(2, world) + this.#at(2, 3) : w;
    return { x: (0.5 + 0.5 * x) * this.width, y: (0.5 - 0.5 * y) * this.height, depth };
  }

  /**
   * A direction of the world in the coordinates of the view: to the right, down, and away from the eye.
   * It keeps its length.
   */
  direction(world: Triple): { right: number; down: number; away: number } {
    const aspect = this.width / this.height;
    const scale = Math.hypot(this.#at(1, 0), this.#at(1, 1), this.#at(1, 2));
    const away = this.#isOrthographic ? 2 : 3;
    return {
      right: (this.#row(0, world) * aspect) / scale,
      down: -this.#row(1, world) / scale,
      away:
        this.#row(away, world) /
        Math.hypot(this.#at(away, 0), this.#at(away, 1), this.#at(away, 2)),
    };
  }

  /**
   * The motion of a point along a line. A step s moves it in the picture by `right` and `down` pixels, each
   * times s / (1 + s · nearing). `nearing` is 0 for parallel rays. Undefined as for `point`.
   */
  motion(
    at: Triple,
    direction: Triple,
  ): { right: number; down: number; nearing: number } | undefined {
    const w = this.#row(3, at) + this.#at(3, 3);
    if (!(w > 0)) return undefined;
    const change = this.#row(3, direction);
    const along = (row: number) => {
      const position = this.#row(row, at) + this.#at(row, 3);
      return (this.#row(row, direction) * w - position * change) / (w * w);
    };
    return {
      right: 0.5 * this.width * along(0),
      down: -0.5 * this.height * along(1),
      nearing: change / w,
    };
  }

  /** CSS pixels per unit of length, for lengths across the view at the depth of a point. */
  pixelsPerUnit(at: Triple): number {
    const depth = this.#row(3, at) + this.#at(3, 3);
    const scale = Math.hypot(this.#at(1, 0), this.#at(1, 1), this.#at(1, 2));
    return depth > 0 ? (scale * this.height) / (2 * depth) : 0;
  }

  get #isOrthographic(): boolean {
    return [0, 1, 2].every((column) => this.#at(3, column) === 0);
  }

  #at(row: number, column: number): number {
    return this.#matrix[4 * column + row] ?? 0;
  }

  #row(row: number, [x, y, z]: Triple): number {
    return this.#at(row, 0) * x + this.#at(row, 1) * y + this.#at(row, 2) * z;
  }
}

/**
 * The picture of a viewer, in an element that covers its canvas. Undefined before the first picture.
 */
export function screenOf(viewer: Viewer, element: HTMLElement): Screen | undefined {
  const { clientWidth: width, clientHeight: height } = element;
  if (width === 0 || height === 0) return undefined;
  const matrix = viewer.viewProjection(width, height);
  return matrix ? new Screen(matrix, width, height) : undefined;
}
