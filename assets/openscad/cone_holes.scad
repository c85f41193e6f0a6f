pts=rands(0,50,60,42);
difference(){ cube([50,50,3]); for(i=[0:29]) translate([pts[2*i],pts[2*i+1],-1]) cylinder(r1=2+i%3,r2=2.2+i%3,h=5,$fn=24); }
