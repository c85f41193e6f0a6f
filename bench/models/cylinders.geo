# What two crossing cylinders of different radius share: curved faces and two closed creases only.
algebraic3d
solid upright = cylinder (0, 0, -1; 0, 0, 1; 1);
solid across = cylinder (-1, 0, 0; 1, 0, 0; 0.8);
solid both = upright and across;
tlo both;
