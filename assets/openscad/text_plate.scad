difference(){ cube([60,20,3]); translate([4,6,2]) linear_extrude(2) text("Mortise",size=10); }
