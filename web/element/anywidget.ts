/**
 * <isosplat-viewer> as a widget of notebooks: a module that follows anywidget's front-end
 * specification (AFM).
 */
import "./index.ts";
import { Notebook, type NotebookModel } from "./notebook.ts";

export type { NotebookModel } from "./notebook.ts";
export type {
  LayerTrait,
  PickedPoint,
  TimeTrait,
  TraitName,
  Traits,
  VolumeTrait,
} from "./notebook_traits.ts";

/** Shows the model in `el`. Returns a function that removes everything again. */
function render({ model, el }: { model: NotebookModel; el: HTMLElement }): () => void {
  const notebook = new Notebook(model);
  el.append(notebook.element);
  return () => notebook.dispose();
}

export default { render };
