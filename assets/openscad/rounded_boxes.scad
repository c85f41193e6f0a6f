$fn=32;
minkowski(){ cube([20,15,10]); sphere(2); }
translate([30,0,0]) hull() for(x=[0,20],y=[0,15],z=[0,10]) translate([x,y,z]) sphere(2);
