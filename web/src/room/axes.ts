// The three axes of a target, as its quaternion turns them.
import { CylinderGeometry, Group, Mesh, MeshBasicMaterial, Quaternion, Vector3 } from "three";
import { XYZ } from "./xyz.ts";

const LENGTH = 0.3; // m, from the surface of the ball
const THICK = 0.012; // m, radius
const UP = new Vector3(0, 1, 0); // along it cylinders are made
const WAYS = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)];

export class Axes {
  readonly group = new Group();
  private readonly goal = new Quaternion();

  // radius: of the ball, m.
  constructor(radius: number) {
    this.group.visible = false;
    const length = radius + LENGTH;
    WAYS.forEach((way, i) => {
      const bar = new Mesh(
        new CylinderGeometry(THICK, THICK, length, 8),
        new MeshBasicMaterial({ color: XYZ[i], transparent: true, fog: false }),
      );
      bar.renderOrder = 1; // over the glow
      bar.quaternion.setFromUnitVectors(UP, way);
      bar.position.copy(way).multiplyScalar(length / 2);
      this.group.add(bar);
    });
  }

  // quaternion: w, x, y, z, from axes of the target to those of the room; none are drawn where it is not known.
  turn(quaternion: (number | null)[] | undefined): void {
    const known = quaternion?.filter((value) => value !== null);
    if (known?.length === 4) {
      const [w, x, y, z] = known;
      this.goal.set(x, y, z, w).normalize();
      if (!this.group.visible) this.group.quaternion.copy(this.goal);
    }
    this.group.visible = known?.length === 4;
  }

  // share: of the way to where they point now.
  step(share: number): void {
    this.group.quaternion.slerp(this.goal, share);
  }
}
