# Unit ball.
algebraic3d
solid ball = sphere (0, 0, 0; 1);
tlo ball;
