cube([40,40,3]); for(i=[0:9]) translate([i*4.1,0,0]) cube([1.2,40,20]);
difference(){ translate([-5,15,0]) cube([50,10,3]); for(x=[-2.5,42.5]) translate([x,20,-1]) cylinder(d=3,h=5,$fn=30);}
