// The solid of ../bracket.geo and assets/models/bracket.csg.
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 4, 2, 1};
Box(2) = {0, 0, 0, 1, 2, 3};
Cylinder(3) = {1.8, 1, -0.5, 0, 0, 2, 0.4};
Cylinder(4) = {3.1, 1, -0.5, 0, 0, 2, 0.4};
Cylinder(5) = {-0.5, 1, 2.1, 2, 0, 0, 0.4};
BooleanUnion(6) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
BooleanDifference(7) = { Volume{6}; Delete; }{ Volume{3, 4, 5}; Delete; };
