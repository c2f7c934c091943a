import type { Triple } from "../stream/index.ts";

/** A point of the picture: CSS pixels from the top left; `depth` grows away from the eye. */
export interface ScreenPoint {
  x: number;
  y: number;
  depth: number;
}

/**
 * Where points of the world are in a picture. `matrix`: world to clip space, 4 × 4, column by
 * column (Viewer.viewProjection).
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
    const depth = this.#row(3, world) + this.#at(3, 3);
    if (!(depth > 0)) return undefined;
    const x = (this.#row(0, world) + this.#at(0, 3)) / depth;
    const y = (this.#row(1, world) + this.#at(1, 3)) / depth;
    return { x: (0.5 + 0.5 * x) * this.width, y: (0.5 - 0.5 * y) * this.height, depth };
  }

  /**
   * A direction of the world as seen in the middle of the picture: to the right, down, and away from
   * the eye. As long as the direction is.
   */
  direction(world: Triple): { right: number; down: number; away: number } {
    const aspect = this.width / this.height;
    const scale = Math.hypot(this.#at(1, 0), this.#at(1, 1), this.#at(1, 2));
    return {
      right: (this.#row(0, world) * aspect) / scale,
      down: -this.#row(1, world) / scale,
      away: this.#row(3, world),
    };
  }

  /** CSS pixels per unit of length, for lengths across the view at the depth of a point. */
  pixelsPerUnit(at: Triple): number {
    const depth = this.#row(3, at) + this.#at(3, 3);
    const scale = Math.hypot(this.#at(1, 0), this.#at(1, 1), this.#at(1, 2));
    return depth > 0 ? (scale * this.height) / (2 * depth) : 0;
  }

  #at(row: number, column: number): number {
    return this.#matrix[4 * column + row] ?? 0;
  }

  #row(row: number, [x, y, z]: Triple): number {
    return this.#at(row, 0) * x + this.#at(row, 1) * y + this.#at(row, 2) * z;
  }
}
