/**
 * From now on, the browser refuses every request of this page to another origin. Called before a file of
 * this device is read; the policy holds until the page is left.
 */
export function forbidOtherOrigins(): void {
  if (document.querySelector("meta[data-no-upload]")) return;
  const policy = document.createElement("meta");
  policy.httpEquiv = "Content-Security-Policy";
  policy.content = "connect-src 'self' data: blob:; form-action 'none'";
  policy.dataset.noUpload = "";
  document.head.append(policy);
}
