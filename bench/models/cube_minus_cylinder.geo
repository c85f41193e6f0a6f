# Unit cube with a through hole near one of its edges.
algebraic3d
solid cube = orthobrick (0, 0, 0; 1, 1, 1);
solid hole = cylinder (0.6, 0.4, 0; 0.6, 0.4, 1; 0.22);
solid part = cube and not hole;
tlo part;
