/** The parts that can be shown over the picture. */
export const overlayParts = ["axes", "scale", "box"] as const;
export type OverlayPart = (typeof overlayParts)[number];

/** The parts that are shown by default. */
export const defaultParts: ReadonlySet<OverlayPart> = new Set<OverlayPart>(["axes", "scale"]);
