# Unit cube without a ball about one of its corners: all creases are right angles, three of them curved.
algebraic3d
solid cube = orthobrick (0, 0, 0; 1, 1, 1);
solid ball = sphere (1, 1, 1; 0.55);
solid part = cube and not ball;
tlo part;
