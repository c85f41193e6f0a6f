difference(){ sphere(20,$fn=100); sphere(17,$fn=100); translate([0,0,-30]) cube(60,center=true); for(i=[0:11]) rotate(30*i) translate([0,0,8]) rotate([90,0,0]) cylinder(r=2,h=40,$fn=24);}
