$fn=36; difference(){ cube([31.8,15.8,9.6]); translate([1.5,1.5,-1]) cube([28.8,12.8,9.1]); }
for(i=[0:3],j=[0:1]) translate([3.9+8*i,3.9+8*j,9.6]) cylinder(d=4.8,h=1.8);
for(i=[0:2]) translate([7.9+8*i,7.9,0]) difference(){ cylinder(d=6.51,h=9); translate([0,0,-1]) cylinder(d=4.8,h=9.5);}
