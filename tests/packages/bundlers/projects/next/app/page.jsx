import View from "./view";

// The server renders the element's tag; the browser defines the element.
export default function Page() {
  return <View />;
}
