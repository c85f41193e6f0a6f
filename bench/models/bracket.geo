# The solid of assets/models/bracket.csg: a base plate and an upright plate, three holes of radius 0.4.
algebraic3d
solid base = orthobrick (0, 0, 0; 4, 2, 1);
solid upright = orthobrick (0, 0, 0; 1, 2, 3);
solid hole1 = cylinder (1.8, 1, 0; 1.8, 1, 1; 0.4);
solid hole2 = cylinder (3.1, 1, 0; 3.1, 1, 1; 0.4);
# Cylinders have no ends: this one stays clear of the base plate.
solid hole3 = cylinder (0, 1, 2.1; 1, 1, 2.1; 0.4);
solid bracket = (base or upright) and not hole1 and not hole2 and not hole3;
tlo bracket;
