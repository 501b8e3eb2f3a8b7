// x, y and z of a place in m, or x, y and radius of a thing in a picture in px.
export type Triple = [number, number, number];
