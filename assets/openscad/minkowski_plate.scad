$fn=40; difference(){ minkowski(){ cube([40,30,3]); cylinder(r=4,h=1);} for(x=[0,40],y=[0,30]) translate([x,y,-1]) cylinder(r=1.7,h=10); translate([10,8,2]) cube([20,14,5]);}
