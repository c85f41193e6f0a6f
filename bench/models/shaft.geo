# Stepped shaft along x with a collar, a keyway and a cross hole.
algebraic3d
solid thick = cylinder (-2, 0, 0; 2, 0, 0; 0.6)
          and plane (-2, 0, 0; -1, 0, 0)
          and plane (0.3, 0, 0; 1, 0, 0);
solid collar = cylinder (-2, 0, 0; 2, 0, 0; 1)
           and plane (0, 0, 0; -1, 0, 0)
           and plane (0.6, 0, 0; 1, 0, 0);
solid thin = cylinder (-2, 0, 0; 2, 0, 0; 0.45)
         and plane (0.3, 0, 0; -1, 0, 0)
         and plane (2, 0, 0; 1, 0, 0);
solid keyway = orthobrick (-1.6, -0.2, 0.3; -0.6, 0.2, 1);
solid bore = cylinder (1.3, 0, -1; 1.3, 0, 1; 0.2);
solid shaft = (thick or collar or thin) and not keyway and not bore;
tlo shaft;
