/** Whether a path or a URL's path names a bundle, by its ending. */
export function isBundleName(path: string): boolean {
  return /\.isobundle$/i.test(path);
}

/** Whether it names the document of a scene: scene.json or NAME.scene.json. */
export function isDocumentName(path: string): boolean {
  return /(^|[/.])scene\.json$/i.test(path);
}

export function isSceneName(path: string): boolean {
  return isBundleName(path) || isDocumentName(path);
}
