/** When a kept answer came from its host, as Date writes it. Only kept answers have this header. */
export const keptHeader = "X-Isosplat-Kept";
