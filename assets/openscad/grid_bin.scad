$fn=32; module pad(s,r,h){ linear_extrude(h) offset(r) square(s-2*r,center=true);} 
difference(){ union(){ hull(){ pad(35.6,0.8,0.01); translate([0,0,0.8]) pad(37.2,1.6,0.01);} translate([0,0,0.8]) pad(37.2,1.6,1.8); hull(){ translate([0,0,2.6]) pad(37.2,1.6,0.01); translate([0,0,4.75]) pad(41.5,3.75,0.01);} translate([0,0,4.75]) pad(41.5,3.75,15);} translate([0,0,6]) pad(39,2.5,20); }
