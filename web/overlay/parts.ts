/** What can be shown above the picture. */
export const overlayParts = ["axes", "scale", "box"] as const;
export type OverlayPart = (typeof overlayParts)[number];

/** What is shown unless the visitor chooses otherwise. */
export const defaultParts: ReadonlySet<OverlayPart> = new Set<OverlayPart>(["axes", "scale"]);
