difference(){ cube([60,40,4]);
 for(i=[0:7]) for(j=[0:6]) translate([4+i*7.2+(j%2)*3.6,4+j*5.6,-1]) cylinder(r=3,h=6,$fn=6);}
