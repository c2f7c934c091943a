/** Whether a path or a URL's path names a bundle, by its ending. */
export function isBundleName(path: string): boolean {
  return /\.isobundle$/i.test(path);
}

/** Whether it names the document of a scene: scene.json or NAME.scene.json. */
export function isDocumentName(path: string): boolean {
  return /(^|[/.])scene\.json$/i.test(path);
}

/** The path of a scene of an Isosplat server: its folder and the escaped name. */
export const servedPath = /^(.*\/)v1\/scenes\/([^/]+)\/?$/;

/** Whether a path or a URL's path names a file of a scene. */
export function isSceneName(path: string): boolean {
  return isBundleName(path) || isDocumentName(path);
}
