$fn=40;
module rbox(s,r){ hull() for(x=[r,s[0]-r],y=[r,s[1]-r]) translate([x,y,0]) cylinder(r=r,h=s[2]); }
difference(){ rbox([60,40,20],4); translate([2,2,2]) rbox([56,36,30],2.5); translate([30,-1,12]) rotate([-90,0,0]) cylinder(r=3,h=50);
 for(i=[0:4]) translate([10+i*9,-1,5]) cube([4,10,4]); }
for(x=[6,54],y=[6,34]) translate([x,y,0]) difference(){ cylinder(r=3.5,h=15); translate([0,0,4]) cylinder(r=1.4,h=20);}
