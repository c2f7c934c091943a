import { maxIsosurfaces } from "../../build/wasm/web/layouts.js";
import type { Category, Triple } from "../core/types.ts";
import { defaultLight, type Light } from "./light.ts";

export const projections = ["perspective", "orthographic"] as const;
/** Orthographic: rays are parallel, and sizes in the picture do not depend on the distance. */
export type Projection = (typeof projections)[number];

/** A view of the volume, as in shared/render/settings/camera.h. Angles in degrees. */
export interface Camera {
  /** The point, in world coordinates, that the camera looks at and orbits. */
  target: Triple;
  /** From the eye to the target, world units. */
  distance: number;
  /** 0: the eye is in front (−y); 90: at +x. */
  azimuth: number;
  /** −90 … 90; 90: the eye is above (+z). */
  elevation: number;
  roll: number;
  /**
   * The vertical field of view. For orthographic views, it determines the size of the view together
   * with `distance`.
   */
  fieldOfView: number;
  /** Default: perspective. */
  projection?: Projection;
}

/** In pixels. */
export interface PictureSize {
  width: number;
  height: number;
}

/** A picture to be drawn in addition to the view of the canvas. */
export interface PictureView extends PictureSize {
  /** Default: that of the viewer. */
  camera?: Camera;
}

export interface PartsOptions {
  /** Without the background. */
  transparent?: boolean;
  /** How many pictures are averaged, 1 … 8: more have smoother edges and shadows. */
  pictures?: number;
}

/** A picture that is drawn in parts: Viewer.beginPicture. */
export interface PictureInParts extends PictureSize {
  /**
   * A part, from its upper left corner: RGBA, alpha not premultiplied, rows from the top. Waits for the GPU.
   * Throws a RendererError.
   */
  draw(x: number, y: number, width: number, height: number): Uint8ClampedArray<ArrayBuffer>;
  /** Ends the picture: the canvas is drawn again. */
  end(): void;
}

/** One isosurface: isovalue in the volume's values, colour as #rrggbb (sRGB), opacity 0 … 1. */
export interface Surface {
  isovalue: number;
  colour: string;
  opacity: number;
}

/** The label of a segmentation whose surface a layer shows. */
export interface Label {
  /** In the file of labels. */
  value: number;
  /** The number of voxels with this value. */
  voxels: number;
  /** The volume of these voxels, in cubic units of the world. */
  volume: number;
}

/** A point of a surface (SurfacePick in shared/render/pick/surface_pick.h). */
export interface SurfacePoint {
  /** World coordinates. */
  position: Triple;
  /** The same in voxels of its layer's volume. */
  voxel: Triple;
  /** World, of unit length, towards the eye. */
  normal: Triple;
  /** Length of the gradient: change of the value per world unit. */
  gradient: number;
  /**
   * The volume's value at this point. On a surface this is its isovalue. On a cap, the value is at
   * least this.
   */
  isovalue: number;
  /** The point is on a cap: Clip.caps. */
  cap?: true;
  /** The point is in a slice. */
  slice?: true;
  /**
   * Distance along the view to the next surface behind it, in world units; undefined if there is
   * none.
   */
  toNext?: number;
  /** The value of the field that colours show: NaN where it has none. Undefined while its values have not arrived. */
  field?: number;
  /** The level of the cell. At 0 the point is exact. */
  level: number;
  /** `Layer.id` of the layer that it belongs to. */
  layer: number;
}

/** The largest number of isosurfaces; more are ignored (kMaxIsosurfaces in shared/render/settings/render_settings.h). */
export const maxSurfaces: number = maxIsosurfaces;

export const splatKinds = ["quad", "ellipse", "exact"] as const;
/** The shape with which a sample is drawn (shared/render/settings/render_settings.h, SplatKind). */
export type SplatKind = (typeof splatKinds)[number];

export const shadings = ["smooth", "exact"] as const;
/** The normals for the lighting of surfaces (shared/render/settings/render_settings.h, Shading). */
export type Shading = (typeof shadings)[number];

/** A kind of splats with its shading. */
export interface Splats {
  kind: SplatKind;
  shading: Shading;
}

export const colourings = [
  "isosurface",
  "isovalue",
  "gradient",
  "depth",
  "level",
  "projection-error",
  "field",
] as const;
/** The quantity that a pixel's colour shows (shared/render/settings/render_settings.h, ColourBy). */
export type Colouring = (typeof colourings)[number];

export const colourMaps = ["viridis", "magma", "cividis", "turbo"] as const;
export type ColourMap = (typeof colourMaps)[number];

export const fieldScales = ["linear", "logarithmic", "symmetric"] as const;
/** How the values of a field are laid out along the colour map (FieldScale in shared/render/settings/render_settings.h). */
export type FieldScale = (typeof fieldScales)[number];

/** How the field of a store is shown, with `colourBy: "field"`. */
export interface FieldLook {
  /** The name of the field. Stores without it have the colours of their surfaces. */
  name: string;
  /** The values of the first and the last colour. Null: the range of the field in the first layer that has it. */
  range: readonly [number, number] | null;
  scale: FieldScale;
  /** The number of colours; 0: the whole colour map. */
  steps: number;
  /**
   * The distance of contour lines, which are where the value is a multiple of it; with a logarithmic scale, where the
   * logarithm to base 10 is. 0: no lines.
   */
  lines: number;
}

/** How the surfaces look. */
export interface Look {
  /** automatic: fast splats while something moves, exact ones at rest. */
  kind: SplatKind | "automatic";
  /** smooth: continuous normals where the view rests, and in close-ups with quads; exact: the gradient of each cell. */
  shading: Shading;
  colourBy: Colouring;
  colourMap: ColourMap;
  field: FieldLook;
  /** #rrggbb, sRGB. */
  background: string;
  light: Light;
  /** Strength of edge shading (eye-dome lighting), 0 … 1. */
  eyeDome: number;
}

/** A change of the look. Of a field, members that are left out have their first values. */
export type LookChange = Partial<Omit<Look, "field">> & {
  field?: Pick<FieldLook, "name"> & Partial<FieldLook>;
};

/** Where a contour line is in the legend. */
export interface LineTick {
  /** 0: at the first colour, 1: at the last one. */
  at: number;
  /** Dark lines are on bright colours, and bright ones on dark colours. */
  isDark: boolean;
}

/** The meaning of colours (shared/render/passes/splat_passes.cpp, scalar_weights). */
export interface Legend {
  colourBy: Exclude<Colouring, "isosurface">;
  /** CSS colours, evenly spaced from low to high; of slices alone: greys, unless they are mapped. */
  colours: readonly string[];
  /** The values of the first and the last colour; null: the nearest and farthest point of the view. */
  range: readonly [number, number] | null;
  /** The field that colours represent, with the units that its file states. */
  field?: { name: string; units?: string; scale: FieldScale; hasMissing?: true };
  /**
   * The values of the field are labels, which have colours of their own: those that occur in the chunks of the drawn
   * surfaces, by value. Then `colours` is empty, and `range` null.
   */
  categories?: readonly Category[];
  /** The contour lines of the field: their distance (FieldLook.lines), and where they are among the colours. */
  lines?: { interval: number; ticks: readonly LineTick[] };
  /** There are slices, which are hatched where no values are loaded. */
  slices?: true;
  /** The values and colours of slices, if the colours above do not represent values. */
  ofSlices?: { range: readonly [number, number]; colours: readonly string[] };
}

/** Keeps the half-space that the normal points to: normal · world ≥ offset. */
export interface ClipPlane {
  normal: Triple;
  offset: number;
}

/** The part of the volume that is shown: inside the box, and in the half-space of every plane. */
export interface Clip {
  /** The box: fractions of the volume's extent along x, y, z. */
  low: Triple;
  high: Triple;
  /** At most `maxClipPlanes`; more are ignored. */
  planes: readonly ClipPlane[];
  /**
   * Closes the cut faces where they cut the solid: where values are at least the isovalue. The volume's
   * own border stays open. Default: false.
   */
  caps?: boolean;
}

/** A plane in the world: normal · world = offset. The normal may have any length. */
export type SlicePlane = ClipPlane;

/**
 * Slices through the volume: planes that show its values where cells are resident, for any
 * isovalue, at the finest resident level. Elsewhere they are hatched.
 */
export interface Slices {
  /** Across x, y and z: the position as a fraction of the volume's extent, 0 … 1; null: none. */
  along: readonly [number | null, number | null, number | null];
  /** An oblique one. */
  plane?: SlicePlane;
  /**
   * The values shown as black and white, unless the colour map represents values (colouring by
   * isovalue). Default: the volume's range.
   */
  range?: readonly [number, number];
  /** In the colours of the look's colour map instead of greys. */
  mapped?: boolean;
}

/** Statistics of the last frame. */
export interface FrameReport {
  samplesDrawn: number;
  samplesResident: number;
  gpuBytes: number;
  kind: SplatKind;
  /** Frames per second during a run of frames; 0 if the view is still. */
  framesPerSecond: number;
}

export const defaultLook: Look = {
  kind: "automatic",
  shading: "smooth",
  colourBy: "isosurface",
  colourMap: "viridis",
  field: { name: "", range: null, scale: "linear", steps: 0, lines: 0 },
  background: "#ffffff",
  light: defaultLight,
  eyeDome: 0.15,
};
