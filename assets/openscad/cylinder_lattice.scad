$fn=16; for(i=[0:4],j=[0:4],k=[0:3]) translate([i*6,j*6,k*6]) { cylinder(r=0.8,h=6); rotate([90,0,0]) cylinder(r=0.8,h=6); rotate([0,90,0]) cylinder(r=0.8,h=6); sphere(1.2);}
