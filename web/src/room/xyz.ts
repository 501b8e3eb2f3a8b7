// The colours of the axes x, y and z.
export const XYZ = ["#ff7a6b", "#6fe39a", "#74a8ff"] as const;
