$fn=60; linear_extrude(8) difference(){ union(){ circle(10); translate([-4,-22]) square([8,14]);} circle(7); polygon([[0,0],[20,14],[20,30],[-20,30],[-20,14]]); translate([-1,-30]) square([2,12]); }
