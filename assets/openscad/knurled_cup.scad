$fn=60;
difference(){ cylinder(r=15,h=20); for(i=[0:29]) rotate(12*i) translate([15.5,0,-1]) cylinder(r=1.2,h=22,$fn=20); translate([0,0,6]) cylinder(r=10,h=20); }
