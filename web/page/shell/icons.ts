import type { TemplateResult } from "lit";
import { html } from "lit";
import { guard } from "lit/directives/guard.js";
import {
  ArrowLeft,
  Box,
  Camera,
  Check,
  ChevronDown,
  ChevronRight,
  ChevronUp,
  CircleAlert,
  CircleQuestionMark,
  CloudOff,
  createElement,
  Download,
  Eye,
  EyeOff,
  GripVertical,
  type IconNode,
  Layers,
  Link,
  Maximize,
  Moon,
  Pause,
  Play,
  Plus,
  RotateCcw,
  SearchX,
  Share2,
  StepBack,
  StepForward,
  Sun,
  Trash,
  Undo2,
} from "lucide";

const icons = {
  alert: CircleAlert,
  back: ArrowLeft,
  camera: Camera,
  check: Check,
  down: ChevronDown,
  grip: GripVertical,
  help: CircleQuestionMark,
  hidden: EyeOff,
  layers: Layers,
  link: Link,
  save: Download,
  maximize: Maximize,
  mesh: Box,
  moon: Moon,
  missing: SearchX,
  next: StepForward,
  offline: CloudOff,
  pause: Pause,
  play: Play,
  plus: Plus,
  open: ChevronRight,
  previous: StepBack,
  reset: RotateCcw,
  share: Share2,
  shown: Eye,
  sun: Sun,
  trash: Trash,
  undo: Undo2,
  up: ChevronUp,
} satisfies Record<string, IconNode>;

export type IconName = keyof typeof icons;

/**
 * An icon without a label: the control that contains it has one. Renders of the page keep the
 * element; otherwise the control would lay itself out again.
 */
export function icon(name: IconName): TemplateResult {
  const drawn = () => createElement(icons[name], { "aria-hidden": "true", class: "icon" });
  return html`${guard([name], drawn)}`;
}
