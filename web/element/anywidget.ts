/** <isosplat-viewer> as a widget of notebooks: a module as anywidget's front-end specification (AFM) has it. */
import "./index.ts";
import { Notebook, type NotebookModel } from "./notebook.ts";

export type { NotebookModel } from "./notebook.ts";
export type { PickedPoint, TraitName, Traits, VolumeTrait } from "./notebook_traits.ts";

/** Shows the model in `el`. Returns what removes all of it again. */
function render({ model, el }: { model: NotebookModel; el: HTMLElement }): () => void {
  const notebook = new Notebook(model);
  el.append(notebook.element);
  return () => notebook.dispose();
}

export default { render };
