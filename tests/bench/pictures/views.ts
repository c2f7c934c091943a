/** The views of docs/PICTURES.md in which Isosplat is compared with other programs. */

export interface View {
  /** The name of the sheet: docs/pictures/compared_NAME.jpg. */
  name: string;
  title: string;
  /**
   * A file in the folder of real volumes: NRRD without orientation, so that world coordinates are
   * those of the volume.
   */
  file: string;
  isovalue: number;
  camera: Camera;
}

/** As in shared/render/settings/camera.h, without roll: degrees, and world units. */
export interface Camera {
  azimuth: number;
  elevation: number;
  distance: number;
  target: Vector;
}
export type Vector = [number, number, number];

/** Size of each picture in px. */
export const size = { width: 400, height: 340 };
/** Vertical, in degrees: the default of the program. */
export const fieldOfView = 30;
/** sRGB of the surfaces and of the background. */
export const colour = "d9ccb3";
export const background = "ffffff";

const volumes: [string, string, number, Camera, Camera][] = [
  [
    "engine",
    "engine.nhdr",
    60.5,
    orbit(30, 20, 480, [127.5, 127.5, 63.5]),
    orbit(30, 20, 150, [80, 40, 80]),
  ],
  [
    "bonsai",
    "bonsai.nhdr",
    40.5,
    orbit(215, 12, 640, [127.5, 127.5, 127.5]),
    orbit(215, 25, 190, [127, 140, 170]),
  ],
  [
    "aneurysm",
    "aneurysm.nhdr",
    100.5,
    orbit(30, 20, 560, [127.5, 127.5, 127.5]),
    orbit(30, 20, 200, [110, 120, 130]),
  ],
  [
    "lobster",
    "lobster.nhdr",
    40.5,
    orbit(20, 55, 560, [150, 161, 38.5]),
    orbit(20, 55, 170, [150, 110, 50]),
  ],
];

export const views: View[] = volumes.flatMap(([name, file, isovalue, overview, closeUp]) => [
  {
    name: `${name}_overview`,
    title: `${name} ${isovalue}, overview`,
    file,
    isovalue,
    camera: overview,
  },
  {
    name: `${name}_close_up`,
    title: `${name} ${isovalue}, close-up`,
    file,
    isovalue,
    camera: closeUp,
  },
]);

function orbit(azimuth: number, elevation: number, distance: number, target: Vector): Camera {
  return { azimuth, elevation, distance, target };
}

/**
 * The position of the eye and the upward direction, as in camera_frame() of
 * shared/render/settings/camera.cpp.
 */
export function eyeAndUp({ azimuth, elevation, distance, target }: Camera): {
  eye: Vector;
  up: Vector;
} {
  const [a, e] = [azimuth, elevation].map((degrees) => (degrees * Math.PI) / 180) as [
    number,
    number,
  ];
  const back: Vector = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
  const up: Vector = [-Math.sin(a) * Math.sin(e), Math.cos(a) * Math.sin(e), Math.cos(e)];
  return { eye: target.map((t, i) => t + distance * (back[i] ?? 0)) as Vector, up };
}
