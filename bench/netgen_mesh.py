"""Meshes a .geo file with Netgen:  python3 netgen_mesh.py MODEL.geo MAXH OUT.msh

Writes Gmsh 2.2 text with all digits; Netgen's own export keeps six. Needs python3-netgen. Prints the seconds
that meshing itself took.
"""

import sys
import time

from netgen.csg import CSGeometry


def main() -> None:
    model, size, path = sys.argv[1:]
    geometry = CSGeometry(model)
    begin = time.monotonic()
    mesh = geometry.GenerateMesh(maxh=float(size))
    seconds = time.monotonic() - begin
    points = [point.p for point in mesh.Points()]
    elements = [[vertex.nr for vertex in element.vertices] for element in mesh.Elements3D()]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n")
        for number, (x, y, z) in enumerate(points, 1):
            file.write(f"{number} {x:.17g} {y:.17g} {z:.17g}\n")
        file.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        for number, (a, b, c, d) in enumerate(elements, 1):
            # Netgen's tetrahedra are wound the other way than Gmsh's.
            file.write(f"{number} 4 2 1 1 {a} {c} {b} {d}\n")
        file.write("$EndElements\n")
    print(f"meshing {seconds:.6f}")


main()
