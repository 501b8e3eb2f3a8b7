// An element with its text and properties.
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  text: string | number = "",
  properties: Partial<HTMLElementTagNameMap[K]> = {},
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  element.textContent = `${text}`;
  return Object.assign(element, properties);
}
