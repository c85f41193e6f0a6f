// Bins NIO leaves by topology: leaves with one surface and a simple sign pattern get a template (SNIO), all
// others go to the certificate (CNIO). Saxena & Perucchio 1992, §4: SNIO and CNIO cells.
//
// Reads   nio (leaves), tapes, surfaces, ops.
// Writes  leaves[i], used[i] (the node mask of shared/tree.h), counts[t * stride + i] elements of type t and
//         facet_counts[i], all zero for CNIO leaves.
// One work-item handles one leaf.
// Guarantees: a leaf is SNIO only if the surface has a sign at all corners, no face or cell centre
// contradicts its corners, one side is a region and the other is outside, and every element of the template
// is positive and not flat with the actual cuts; so its face meshes are those of the certificate
// (algorithms.md §3).
#include "shared/bounds.h"
#include "shared/snio.h"
#include "shared/surface.h"
#include "shared/tape.h"
#include "shared/template_table.h"
#include "shared/tree.h"

#define MIN_RELATIVE_VOLUME 1e-9

// Value of a tape whose literals are all of one surface, with that surface's sign given.
int evaluate_tape(__global const uint* tape, uint length, uint inside) {
    int value[kTapeStack];
    int top = -1;
    for (uint i = 0; i < length; ++i) {
        const uint word = tape[i];
        const uint operation = tape_operation(word);
        if (operation == kTapeLiteral) {
            value[++top] = (int)(inside ^ tape_negated(word));
        } else if (operation == kTapeSelectConst) {
            value[top] = combine_select(tape_otherwise(word), value[top], tape_region(word));
        } else {
            const int b = value[top--];
            const int a = value[top];
            value[top] = operation == kTapeAnd  ? combine_and(a, b)
                         : operation == kTapeOr ? combine_or(a, b)
                                                : combine_select(a, b, tape_region(word));
        }
    }
    return value[0];
}

double corner_volume(const double (*p)[3], int o, int a, int b, int c) {
    const double ux = p[a][0] - p[o][0];
    const double uy = p[a][1] - p[o][1];
    const double uz = p[a][2] - p[o][2];
    const double vx = p[b][0] - p[o][0];
    const double vy = p[b][1] - p[o][1];
    const double vz = p[b][2] - p[o][2];
    const double wx = p[c][0] - p[o][0];
    const double wy = p[c][1] - p[o][1];
    const double wz = p[c][2] - p[o][2];
    const double volume = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
    const double size =
        sqrt((ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz) * (wx * wx + wy * wy + wz * wz));
    return size > 0 ? volume / size : 0;
}

// Smallest corner volume of unit edges, over the corners that decide positivity (for tetrahedra, wedges and
// pyramids; for hexahedra the eight corners are necessary, and with one moved face sufficient: the Jacobian
// of a hexahedron whose four side edges are parallel is linear along them).
double worst_corner(const double (*p)[3], int type, const int* n) {
    double worst = 1;
    if (type == 3) return corner_volume(p, n[0], n[1], n[2], n[3]);
    if (type == 2) {
        for (int i = 0; i < 4; ++i) {
            worst = fmin(worst, corner_volume(p, n[i], n[(i + 1) & 3], n[(i + 3) & 3], n[4]));
        }
        return worst;
    }
    if (type == 1) {
        for (int i = 0; i < 3; ++i) {
            worst = fmin(worst, corner_volume(p, n[i], n[(i + 1) % 3], n[(i + 2) % 3], n[i + 3]));
            worst = fmin(worst, corner_volume(p, n[i + 3], n[3 + (i + 2) % 3], n[3 + (i + 1) % 3], n[i]));
        }
        return worst;
    }
    for (int i = 0; i < 4; ++i) {
        worst = fmin(worst, corner_volume(p, n[i], n[(i + 1) & 3], n[(i + 3) & 3], n[i + 4]));
        worst = fmin(worst, corner_volume(p, n[i + 4], n[4 + ((i + 3) & 3)], n[4 + ((i + 1) & 3)], n[i]));
    }
    return worst;
}

// Whether every element of the template is positive with the cuts of this leaf.
int template_holds(const TemplateRow* row, const double (*p)[3]) {
    const int sizes[4] = {8, 6, 5, 4};
    uint at = row->first_node;
    for (int type = 0; type < 4; ++type) {
        for (int i = 0; i < row->elements[type]; ++i) {
            int n[8];
            for (int k = 0; k < sizes[type]; ++k) n[k] = kTemplateNodes[at++];
            if (!(worst_corner(p, type, n) > MIN_RELATIVE_VOLUME)) return 0;
        }
    }
    return 1;
}

MORTISE_KERNEL void classify(__global const TreeNode* nio, __global const uint* tapes,
                             __global const Surface* surfaces, __global const ExpressionOp* ops,
                             __global SnioLeaf* leaves, __global uint* used, __global uint* counts,
                             __global uint* facet_counts, uint stride, int level, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const TreeNode node = nio[item];
        __global const uint* tape = tapes + node.tape_offset;
        const double cell = 1.0 / (double)(1u << level);
        const double x = (double)gather_bits(node.morton) * cell;
        const double y = (double)gather_bits(node.morton >> 1) * cell;
        const double z = (double)gather_bits(node.morton >> 2) * cell;
        __global const Surface* surface;
        SnioLeaf leaf;
        TemplateRow row;
        uint mask = 0;
        int simple = 1;
        int value_inside;
        int value_outside;
        int pattern = 0;
        leaf.surface = tape_surface(tape[0]);
        leaf.pattern = kPatternCnio;
        leaf.region = 0;
        for (uint i = 0; i < node.tape_length && simple; ++i) {
            simple = tape_operation(tape[i]) != kTapeLiteral || tape_surface(tape[i]) == leaf.surface;
        }
        for (int i = 0; i < 4; ++i) row.elements[i] = 0;
        row.facets = 0;
        if (simple) {
            value_inside = evaluate_tape(tape, node.tape_length, 1);
            value_outside = evaluate_tape(tape, node.tape_length, 0);
            simple = (value_inside == 0) != (value_outside == 0);
        }
        if (simple) {
            surface = surfaces + leaf.surface;
            for (int c = 0; c < 8 && simple; ++c) {
                const int sign = surface_sign(surface, ops, x + (c & 1) * cell, y + ((c >> 1) & 1) * cell,
                                              z + (c >> 2) * cell, cell);
                simple = sign != 0;
                if (simple && (sign < 0 ? value_inside : value_outside) != 0) pattern |= 1 << c;
            }
        }
        if (simple) {
            row = kTemplateRows[pattern];
            simple = pattern == 0 || pattern == 255 || row.shape != 0;
        }
        // Faces whose corners agree must agree with their centre, and so must the cell.
        for (int f = 0; f < 6 && simple; ++f) {
            int inside = 0;
            for (int i = 0; i < 4; ++i) inside += (pattern >> kFaceCorners[f][i]) & 1;
            if (inside == 0 || inside == 4) {
                const int axis = f >> 1;
                const double side = (f & 1) ? 1.0 : 0.0;
                const int sign = surface_sign(surface, ops, x + (axis == 0 ? side : 0.5) * cell,
                                              y + (axis == 1 ? side : 0.5) * cell,
                                              z + (axis == 2 ? side : 0.5) * cell, cell);
                simple = sign == 0 || ((sign < 0 ? value_inside : value_outside) != 0) == (inside == 4);
            }
        }
        if (simple && (pattern == 0 || pattern == 255)) {
            const int sign = surface_sign(surface, ops, x + 0.5 * cell, y + 0.5 * cell, z + 0.5 * cell, cell);
            simple = sign == 0 || ((sign < 0 ? value_inside : value_outside) != 0) == (pattern == 255);
        }
        if (simple && pattern != 0 && pattern != 255) {
            double p[21][3];
            for (int c = 0; c < 8; ++c) {
                p[c][0] = c & 1;
                p[c][1] = (c >> 1) & 1;
                p[c][2] = c >> 2;
            }
            for (int e = 0; e < 12; ++e) {
                if ((row.cuts >> e) & 1) {
                    const int low = kEdgeCorners[e][0];
                    double a[3];
                    double b[3];
                    a[0] = x + p[low][0] * cell;
                    a[1] = y + p[low][1] * cell;
                    a[2] = z + p[low][2] * cell;
                    for (int j = 0; j < 3; ++j) {
                        b[j] = a[j] + (e / 4 == j ? cell : 0);
                        p[8 + e][j] = p[low][j];
                    }
                    p[8 + e][e / 4] = (double)edge_root(surface, ops, a, b) / (double)kCellUnits;
                }
            }
            if (row.interior_mean != 0) {
                for (int j = 0; j < 3; ++j) {
                    double sum = 0;
                    for (int i = 0; i < 20; ++i) sum += (row.interior_mean >> i) & 1 ? p[i][j] : 0;
                    p[20][j] = sum / (double)popcount(row.interior_mean);
                }
            }
            simple = template_holds(&row, p);
        }
        if (simple) {
            leaf.pattern = (ushort)pattern;
            leaf.region = (ushort)(value_inside != 0 ? value_inside : value_outside);
            if (pattern == 255) {
                mask = 0xff;
            } else if (pattern != 0) {
                mask = row.corners | ((uint)row.cuts << 8) |
                       (row.interior_mean != 0 ? 1u << kInteriorNodeBit : 0u);
            }
        }
        leaves[item] = leaf;
        used[item] = mask;
        {
            const int whole = simple && pattern == 255;
            const int filled = simple && pattern != 0 && pattern != 255;
            for (int t = 0; t < 4; ++t) {
                counts[t * stride + item] = filled ? row.elements[t] : (t == 0 && whole ? 1 : 0);
            }
            facet_counts[item] = filled ? row.facets : 0;
        }
    }
}
