// Shows a view of isosplat.view(). The kernel sends this text to notebooks, which run it as a module of
// anywidget, or in a page of its own.
//
// KERNEL is what the kernel states: address (of the volume or scene, for programs of its machine), path (the
// same without the server), port, proxy (an address with {port}, or ""), content (the id of the content), and
// bytes (the size of the file).

/** The addresses at which this browser may reach the kernel's server, the most likely one first. */
function basesOf({ port, proxy }) {
  const page = new URL(document.baseURI);
  if (proxy) return [new URL(proxy.replaceAll("{port}", port), page).href.replace(/\/*$/, "/")];
  const jupyter = jupyterBase();
  // Loopback addresses are those of the visitor's machine. From a page of another machine, only an editor's own
  // page (vscode-webview:) can expect the kernel there.
  const isLocal =
    !/^https?:$/.test(page.protocol) || /^(localhost|127\.0\.0\.1|\[::1\])$/.test(page.hostname);
  return [
    ...(isLocal ? [`http://127.0.0.1:${port}/`, `http://localhost:${port}/`] : []),
    ...(jupyter ? [`${jupyter}proxy/${port}/`] : []), // of jupyter-server-proxy
  ];
}

/** The address of the Jupyter server of this page, or of the page around it. */
function jupyterBase() {
  for (const view of new Set([window, window.parent])) {
    try {
      const { document: page, location } = view;
      const config = page.getElementById("jupyter-config-data");
      const base = config ? JSON.parse(config.textContent).baseUrl : page.body.dataset.baseUrl;
      if (base) return new URL(base, location.href).href.replace(/\/*$/, "/");
    } catch {} // a page of another origin, or of another program
  }
  return "";
}

/** The address of the kernel's server, which knows the content; undefined: this browser cannot reach it. */
async function reach(kernel) {
  for (const base of basesOf(kernel)) {
    try {
      const response = await fetch(base + kernel.path, { signal: AbortSignal.timeout(10_000) });
      if ((await response.json()).contentId === kernel.content) return base;
    } catch {} // no server, another one, or none that this page may read
  }
}

/** Of each model: all its views use the same objects. */
const bases = new WeakMap();
const addressed = new WeakMap();

function once(map, key, make) {
  if (!map.has(key)) map.set(key, make());
  return map.get(key);
}

/**
 * The code of the widget, once for the page and in one file: a kernel that is restarted has another server, and a
 * page can define the element only once.
 */
function widgetModule(load) {
  globalThis.isosplatWidget ??= load().catch((error) => {
    globalThis.isosplatWidget = undefined;
    throw error;
  });
  return globalThis.isosplatWidget;
}

/** The model with the address at which this browser reaches the server. */
function withAddress(model, { address, path }, base) {
  return {
    get: (name) => {
      const value = model.get(name);
      return value === address ? base + path : value;
    },
    set: (name, value) => model.set(name, value),
    save_changes: () => model.save_changes(),
    on: (event, listener) => model.on(event, listener),
    off: (event, listener) => model.off(event, listener),
  };
}

/** The code of the widget, which the kernel sends in a message. */
function moduleByMessage(model) {
  const id = `module ${Math.random()}`;
  return new Promise((resolve, reject) => {
    const listen = (content, buffers) => {
      if (content?.kind !== "module" || content.id !== id) return;
      model.off("msg:custom", listen);
      const [code] = buffers ?? [];
      if (!code)
        return reject(new Error(`isosplat: the kernel cannot send the viewer: ${content.error}`));
      const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
      import(/* @vite-ignore */ url).then(resolve, reject);
    };
    model.on("msg:custom", listen);
    model.send({ kind: "module", id });
  });
}

async function render({ model, el }) {
  const kernel = model.get("_kernel");
  const base = await once(bases, model, () => reach(kernel));
  const { default: widget, kernelFile } = await widgetModule(() =>
    base
      ? import(/* @vite-ignore */ `${base}isosplat-anywidget-single.js`)
      : moduleByMessage(model),
  );
  if (base) {
    const reached = once(addressed, model, () => withAddress(model, kernel, base));
    return widget.render({ model: reached, el });
  }
  const fileOf = (address) =>
    address === kernel.address ? kernelFile(model, kernel.bytes) : undefined;
  return widget.render({ model, el, fileOf });
}

/** Shows a view in this page, which has no kernel. */
async function showPage(kernel, traits) {
  const listeners = new Map();
  const values = {
    ...{ src: "", scene: "", step: null, layers: [], isovalue: null, surfaces: [], camera: null },
    ...{ clip: null, slices: null, background: "", controls: true, show: "", link: "" },
    ...traits,
    _kernel: kernel,
  };
  const model = {
    get: (name) => values[name],
    set(name, value) {
      values[name] = value;
      for (const listener of [...(listeners.get(name) ?? [])]) listener();
    },
    save_changes() {},
    on: (event, listener) => {
      const name = event.replace("change:", "");
      listeners.set(name, (listeners.get(name) ?? new Set()).add(listener));
    },
    off: (event, listener) => void listeners.get(event.replace("change:", ""))?.delete(listener),
  };
  const base = await once(bases, model, () => reach(kernel));
  if (base) return render({ model, el: document.body });
  document.body.textContent =
    `Isosplat: this browser cannot reach port ${kernel.port} of the kernel's machine. Install anywidget ` +
    "for the kernel, which reads through its messages, or give isosplat.view(…, proxy=) the address of the port.";
}

export { showPage };
export default { render };
